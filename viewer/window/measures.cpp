#include "viewer/window/measures.hpp"

#include <vtkAngleRepresentation2D.h>
#include <vtkAngleWidget.h>
#include <vtkAxisActor2D.h>
#include <vtkCommand.h>
#include <vtkDistanceRepresentation2D.h>
#include <vtkDistanceWidget.h>
#include <vtkFocalPlanePointPlacer.h>
#include <vtkHandleRepresentation.h>
#include <vtkLeaderActor2D.h>
#include <vtkNew.h>
#include <vtkPointHandleRepresentation2D.h>
#include <vtkPolygonalSurfacePointPlacer.h>
#include <vtkProperty2D.h>
#include <vtkRenderer.h>
#include <vtkTextProperty.h>

#include <utility>

namespace angio::viewer::window {
namespace {

vtkSmartPointer<vtkPointPlacer> make_placer(const std::vector<vtkActor*>& surfaces) {
  if (surfaces.empty()) return vtkSmartPointer<vtkFocalPlanePointPlacer>::New();
  auto placer = vtkSmartPointer<vtkPolygonalSurfacePointPlacer>::New();
  for (vtkActor* surface : surfaces) placer->AddProp(surface);
  return placer;
}

void style(vtkTextProperty* text) {
  text->SetColor(1.0, 0.86, 0.2);
  text->SetFontFamilyToArial();
  text->SetFontSize(14);
  text->ItalicOff();
  text->ShadowOn();
}

}  // namespace

Measures::Measures(vtkRenderWindowInteractor* interactor,
                   std::function<vtkRenderer*(int, int)> find_renderer,
                   std::function<std::vector<vtkActor*>(vtkRenderer*)> surfaces_of)
    : interactor_(interactor),
      find_renderer_(std::move(find_renderer)),
      surfaces_of_(std::move(surfaces_of)) {
  constexpr float kBeforeTheMouse = 0.4f;  // buttons, which are widgets, have 0.5; the style 0
  observer_ = interactor_->AddObserver(vtkCommand::LeftButtonPressEvent, this, &Measures::on_press,
                                       kBeforeTheMouse);
}

Measures::~Measures() {
  erase();
  interactor_->RemoveObserver(observer_);
}

void Measures::start(MeasureKind kind) {
  is_waiting_ = !is_waiting(kind);
  waiting_kind_ = kind;
}

void Measures::erase() {
  is_waiting_ = false;
  for (const auto& widget : widgets_) widget->Off();
  widgets_.clear();
}

bool Measures::on_press(vtkObject*, unsigned long, void*) {
  if (!is_waiting_) return false;
  const int* place = interactor_->GetEventPosition();
  vtkRenderer* view = find_renderer_(place[0], place[1]);
  if (!view) return false;
  is_waiting_ = false;
  if (waiting_kind_ == MeasureKind::distance)
    add_distance(view);
  else
    add_angle(view);
  interactor_->InvokeEvent(vtkCommand::LeftButtonPressEvent);  // its first point
  return true;
}

template <class Widget, class Representation>
void Measures::begin(Widget* widget, Representation* look, vtkRenderer* view) {
  look->SetRenderer(view);
  widget->SetInteractor(interactor_);
  widget->SetDefaultRenderer(view);
  widget->SetCurrentRenderer(view);
  widget->SetRepresentation(look);
  widget->On();
  widgets_.push_back(widget);
}

void Measures::add_distance(vtkRenderer* view) {
  vtkNew<vtkDistanceWidget> widget;
  vtkNew<vtkDistanceRepresentation2D> look;
  look->InstantiateHandleRepresentation();
  const auto placer = make_placer(surfaces_of_(view));
  look->GetPoint1Representation()->SetPointPlacer(placer);
  look->GetPoint2Representation()->SetPointPlacer(placer);
  look->SetLabelFormat("%.2f mm");
  look->GetAxis()->GetProperty()->SetColor(1.0, 0.86, 0.2);
  look->GetAxis()->GetProperty()->SetLineWidth(2.0f);
  look->GetAxis()->UseFontSizeFromPropertyOn();
  look->GetAxis()->SetNumberOfMinorTicks(0);
  look->SetNumberOfRulerTicks(1);
  style(look->GetAxis()->GetTitleTextProperty());
  begin(widget.Get(), look.Get(), view);
}

void Measures::add_angle(vtkRenderer* view) {
  vtkNew<vtkAngleWidget> widget;
  vtkNew<vtkAngleRepresentation2D> look;
  look->InstantiateHandleRepresentation();
  const auto placer = make_placer(surfaces_of_(view));
  look->GetPoint1Representation()->SetPointPlacer(placer);
  look->GetCenterRepresentation()->SetPointPlacer(placer);
  look->GetPoint2Representation()->SetPointPlacer(placer);
  look->SetLabelFormat("%.1f degrees");
  for (vtkLeaderActor2D* part : {look->GetRay1(), look->GetRay2(), look->GetArc()}) {
    part->GetProperty()->SetColor(1.0, 0.86, 0.2);
    style(part->GetLabelTextProperty());
  }
  begin(widget.Get(), look.Get(), view);
}

std::vector<double> Measures::values() const {
  std::vector<double> values;
  for (const auto& widget : widgets_) {
    if (auto* distance = vtkDistanceWidget::SafeDownCast(widget))
      if (distance->GetWidgetState() == vtkDistanceWidget::Manipulate)
        values.push_back(
            vtkDistanceRepresentation::SafeDownCast(distance->GetRepresentation())->GetDistance());
    if (auto* angle = vtkAngleWidget::SafeDownCast(widget))
      if (angle->GetWidgetState() == vtkAngleWidget::Manipulate)
        values.push_back(
            vtkAngleRepresentation::SafeDownCast(angle->GetRepresentation())->GetAngle());
  }
  return values;
}

}  // namespace angio::viewer::window
