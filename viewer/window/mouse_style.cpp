#include "viewer/window/mouse_style.hpp"

#include <vtkObjectFactory.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <utility>

namespace angio::viewer::window {

vtkStandardNewMacro(MouseStyle);

void MouseStyle::set_panels(Panels panels) { panels_ = std::move(panels); }

vtkRenderer* MouseStyle::find_panel() {
  const int* place = Interactor->GetEventPosition();
  FindPokedRenderer(place[0], place[1]);
  return CurrentRenderer;
}

bool MouseStyle::is_slice(vtkRenderer* panel) const {
  return std::find(panels_.slices.begin(), panels_.slices.end(), panel) != panels_.slices.end();
}

void MouseStyle::OnLeftButtonDown() {
  vtkRenderer* panel = find_panel();
  if (is_slice(panel)) {
    drag_ = Drag::grey;
  } else if (panel == panels_.curve) {
    drag_ = Drag::curve;
    panels_.on_curve(Interactor->GetEventPosition()[0]);
  } else {
    Superclass::OnLeftButtonDown();
  }
}

void MouseStyle::OnLeftButtonUp() {
  if (std::exchange(drag_, Drag::none) == Drag::none) Superclass::OnLeftButtonUp();
}

void MouseStyle::OnMiddleButtonDown() {
  if (find_panel() != panels_.curve) Superclass::OnMiddleButtonDown();
}

void MouseStyle::OnRightButtonDown() {
  if (find_panel() != panels_.curve) Superclass::OnRightButtonDown();
}

void MouseStyle::OnMouseMove() {
  const int* now = Interactor->GetEventPosition();
  const int* before = Interactor->GetLastEventPosition();
  if (drag_ == Drag::grey)
    panels_.on_grey(now[0] - before[0], now[1] - before[1]);
  else if (drag_ == Drag::curve)
    panels_.on_curve(now[0]);
  else
    Superclass::OnMouseMove();
}

void MouseStyle::OnMouseWheelForward() {
  vtkRenderer* panel = find_panel();
  if (is_slice(panel) || panel == panels_.curve)
    panels_.on_scroll(panel, 1);
  else
    Superclass::OnMouseWheelForward();
}

void MouseStyle::OnMouseWheelBackward() {
  vtkRenderer* panel = find_panel();
  if (is_slice(panel) || panel == panels_.curve)
    panels_.on_scroll(panel, -1);
  else
    Superclass::OnMouseWheelBackward();
}

}  // namespace angio::viewer::window
