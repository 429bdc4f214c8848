#include "viewer/window/plain_slider.hpp"

#include <vtkProperty2D.h>
#include <vtkTextProperty.h>

#include "viewer/window/colors.hpp"

namespace angio::viewer::window {
namespace {

void paint(vtkProperty2D* property, const detail::Rgb& color) {
  property->SetColor(color[0] / 255.0, color[1] / 255.0, color[2] / 255.0);
}

}  // namespace

PlainSlider make_slider(vtkRenderWindowInteractor* interactor, vtkRenderer* front) {
  PlainSlider slider{vtkSmartPointer<vtkSliderRepresentation2D>::New(),
                     vtkSmartPointer<vtkSliderWidget>::New(),
                     {}};
  vtkSliderRepresentation2D* look = slider.look;
  look->SetMinimumValue(0.0);
  look->SetMaximumValue(1.0);
  look->ShowSliderLabelOff();
  look->SetTitleText("");
  paint(look->GetSliderProperty(), colors::kInk);
  paint(look->GetSelectedProperty(), colors::kCursor);
  paint(look->GetTubeProperty(), colors::kButtonTouched);
  paint(look->GetCapProperty(), colors::kButtonTouched);
  vtkTextProperty* label = look->GetLabelProperty();
  label->SetColor(0.87, 0.89, 0.91);
  label->ShadowOff();
  label->BoldOff();
  label->ItalicOff();
  label->SetFontFamilyToArial();
  slider.widget->SetInteractor(interactor);
  slider.widget->SetDefaultRenderer(front);
  slider.widget->SetCurrentRenderer(front);
  slider.widget->SetRepresentation(look);
  slider.widget->SetAnimationModeToJump();
  return slider;
}

void place(PlainSlider& slider, const PixelBox& track, vtkRenderer* front) {
  slider.track = track;
  slider.widget->SetEnabled(track.width > 0 ? 1 : 0);
  if (track.width <= 0) return;
  const double middle = track.bottom + 0.5 * track.height;
  slider.look->GetPoint1Coordinate()->SetCoordinateSystemToDisplay();
  slider.look->GetPoint1Coordinate()->SetValue(track.left, middle);
  slider.look->GetPoint2Coordinate()->SetCoordinateSystemToDisplay();
  slider.look->GetPoint2Coordinate()->SetValue(track.right(), middle);
  const int* window = front->GetSize();  // VTK counts in parts of it
  slider.look->SetSliderLength(8.0 / window[0]);
  slider.look->SetSliderWidth(16.0 / window[1]);
  slider.look->SetTubeWidth(4.0 / window[1]);
  slider.look->SetEndCapLength(0.0);
  slider.look->SetEndCapWidth(4.0 / window[1]);
  slider.look->SetLabelHeight(14.0 / window[1]);
  slider.look->BuildRepresentation();
}

}  // namespace angio::viewer::window
