#include "viewer/window/image_panel.hpp"

#include <vtkCamera.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>

#include <utility>

#include "formats/vtk_arrays.hpp"
#include "viewer/detail/plane.hpp"
#include "viewer/window/colors.hpp"

namespace angio::viewer::window {
namespace {

constexpr double kEyeMm = 500.0;  // distance of the camera; parallel projection

vtkSmartPointer<vtkTextActor> add_text(vtkRenderer* renderer, int size, double x, double y) {
  auto text = detail::make_text("", size, colors::kInk);
  text->GetTextProperty()->SetBackgroundColor(0.0, 0.0, 0.0);
  text->GetTextProperty()->SetBackgroundOpacity(0.45);
  text->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  text->SetPosition(x, y);
  renderer->AddActor2D(text);
  return text;
}

}  // namespace

ImagePanel::ImagePanel(const ScanImage* scan, double half_height_mm)
    : renderer_(vtkSmartPointer<vtkRenderer>::New()), scale_bar_(renderer_, 1, colors::kCursor) {
  renderer_->SetBackground(0.03, 0.035, 0.045);
  renderer_->GetActiveCamera()->ParallelProjectionOn();
  renderer_->GetActiveCamera()->SetParallelScale(half_height_mm);
  if (scan) {
    mapper_->SetInputData(scan->image);
    mapper_->SliceFacesCameraOn();
    mapper_->SliceAtFocalPointOn();
    mapper_->ResampleToScreenPixelsOff();
    mapper_->SetSlabTypeToMax();
    slice_->SetMapper(mapper_);
    slice_->SetProperty(scan->look);
    slice_->SetUserMatrix(scan->lps_from_image);
    renderer_->AddViewProp(slice_);
  }
  title_ = add_text(renderer_, 13, 0.02, 0.975);
  title_->GetTextProperty()->SetVerticalJustificationToTop();
  footer_ = add_text(renderer_, 12, 0.98, 0.025);
  footer_->GetTextProperty()->SetJustificationToRight();
  const std::array<std::array<double, 2>, 4> places{
      {{0.012, 0.5}, {0.988, 0.5}, {0.5, 0.82}, {0.5, 0.025}}};
  for (std::size_t side = 0; side < 4; ++side) {
    letters_[side] = add_text(renderer_, 14, places[side][0], places[side][1]);
    vtkTextProperty* text = letters_[side]->GetTextProperty();
    text->SetColor(1.0, 0.86, 0.2);
    if (side == 1) text->SetJustificationToRight();
    if (side >= 2) text->SetJustificationToCentered();
    if (side == 2) text->SetVerticalJustificationToTop();
  }
}

void ImagePanel::look_at(const PanelPlane& plane) {
  vtkCamera* camera = renderer_->GetActiveCamera();
  Vec3 focus = plane.point;
  if (!plane.is_new) {  // keep what the user has moved in the plane
    Vec3 before;
    camera->GetFocalPoint(before.x, before.y, before.z);
    focus = before + dot(plane.point - before, plane.direction) * plane.direction;
  }
  const Vec3 eye = focus - kEyeMm * plane.direction;
  camera->SetFocalPoint(focus.x, focus.y, focus.z);
  camera->SetPosition(eye.x, eye.y, eye.z);
  camera->SetViewUp(plane.up.x, plane.up.y, plane.up.z);
  camera->SetClippingRange(0.5 * kEyeMm, 1.5 * kEyeMm);
  plane_point_ = focus;
  plane_normal_ = plane.direction;
  for (Line& line : lines_) cut(line);
}

void ImagePanel::cut(Line& line) const {
  if (!line.mesh) return;
  const Vec3 lift = -0.5 * plane_normal_;  // lines lie over the slice
  std::vector<Vec3> points;
  std::vector<std::vector<int>> pieces;
  for (const auto& [a, b] : detail::cut(*line.mesh, plane_point_, plane_normal_)) {
    const int first = int(points.size());
    points.push_back(a + lift);
    points.push_back(b + lift);
    pieces.push_back({first, first + 1});
  }
  vtkNew<vtkPolyData> lines;
  lines->SetPoints(formats::to_vtk(points));
  lines->SetLines(formats::to_vtk_cells(pieces));
  line.mapper->SetInputData(lines);
}

void ImagePanel::set_half_height(double half_height_mm) {
  renderer_->GetActiveCamera()->SetParallelScale(half_height_mm);
}

void ImagePanel::set_slab(double thickness_mm) { mapper_->SetSlabThickness(thickness_mm); }

void ImagePanel::set_contours(const std::vector<Contour>& contours) {
  while (lines_.size() < contours.size()) {
    Line line{nullptr, vtkSmartPointer<vtkPolyDataMapper>::New(), vtkSmartPointer<vtkActor>::New()};
    line.mapper->ScalarVisibilityOff();
    line.actor->SetMapper(line.mapper);
    line.actor->GetProperty()->LightingOff();
    line.actor->GetProperty()->SetLineWidth(2.0f);
    renderer_->AddActor(line.actor);
    lines_.push_back(line);
  }
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const TriangleMesh* mesh = i < contours.size() ? contours[i].mesh : nullptr;
    const bool is_new = mesh != std::exchange(lines_[i].mesh, mesh);
    lines_[i].actor->SetVisibility(mesh ? 1 : 0);
    if (!mesh) continue;
    if (is_new) cut(lines_[i]);
    const detail::Rgb& color = contours[i].color;
    lines_[i].actor->GetProperty()->SetColor(color[0] / 255.0, color[1] / 255.0, color[2] / 255.0);
  }
}

void ImagePanel::set_words(const std::string& title, const std::string& footer) {
  title_->SetInput(title.c_str());
  footer_->SetInput(footer.c_str());
}

void ImagePanel::set_edge_letters(const std::array<std::string, 4>& letters) {
  for (std::size_t side = 0; side < 4; ++side) letters_[side]->SetInput(letters[side].c_str());
}

}  // namespace angio::viewer::window
