#include "viewer/window/scene_view.hpp"

#include <vtkColorTransferFunction.h>
#include <vtkDecimatePro.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "formats/files.hpp"
#include "formats/vtk_arrays.hpp"
#include "viewer/detail/view_frame.hpp"
#include "viewer/window/projection_volume.hpp"

namespace angio::viewer::window {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kWireRadiusMm = 0.18;  // a wire of 0.014 inch
const detail::Rgb kWireColor{225, 228, 235};

std::size_t place(Layer layer) { return std::size_t(layer); }

/// With at most about kMostTriangles, as smooth shading hides: what is drawn again and again.
vtkSmartPointer<vtkPolyData> thinned(vtkPolyData* surface) {
  constexpr double kMostTriangles = 60'000.0;
  const double share = kMostTriangles / double(std::max<vtkIdType>(surface->GetNumberOfPolys(), 1));
  if (share >= 1.0) return surface;
  vtkNew<vtkDecimatePro> thin;
  thin->SetInputData(surface);
  thin->SetTargetReduction(1.0 - share);
  thin->PreserveTopologyOn();
  thin->BoundaryVertexDeletionOff();  // the wall goes on there
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputConnection(thin->GetOutputPort());
  normals->SplittingOff();
  normals->ConsistencyOff();
  normals->Update();
  return normals->GetOutput();
}

std::array<double, 3> coordinates(const Vec3& point) { return {point.x, point.y, point.z}; }

vtkSmartPointer<vtkPolyData> shaded(const TriangleMesh& mesh) {
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(formats::to_vtk(mesh));
  normals->SplittingOff();
  normals->ConsistencyOff();
  normals->Update();
  return normals->GetOutput();
}

/// The tree's lines; the way from the inlet that many paths share is drawn for the first of them.
vtkSmartPointer<vtkPolyData> each_stretch_once(const std::vector<CenterlinePath>& paths) {
  std::vector<Vec3> points;
  std::vector<std::vector<int>> lines;
  std::set<std::array<double, 3>> known;
  for (const CenterlinePath& path : paths) {
    std::size_t first = 0;
    while (first < path.points.size() && known.contains(coordinates(path.points[first]))) ++first;
    first = first == 0 ? 0 : first - 1;
    std::vector<int> line;
    for (std::size_t i = first; i < path.points.size(); ++i) {
      known.insert(coordinates(path.points[i]));
      const bool is_end = i == first || i + 1 == path.points.size();
      constexpr double kCoarse = 0.4;  // of the radius: as straight as it is seen
      if (!is_end && distance(points.back(), path.points[i]) < kCoarse * path.inscribed_radius[i])
        continue;
      line.push_back(int(points.size()));
      points.push_back(path.points[i]);
    }
    if (line.size() > 1) lines.push_back(line);
  }
  auto tree = vtkSmartPointer<vtkPolyData>::New();
  tree->SetPoints(formats::to_vtk(points));
  tree->SetLines(formats::to_vtk_cells(lines));
  return tree;
}

void set_color(vtkActor* actor, const detail::Rgb& color) {
  actor->GetProperty()->SetColor(color[0] / 255.0, color[1] / 255.0, color[2] / 255.0);
}

}  // namespace

SceneView::SceneView(const detail::CaseData& data, const TreatedLine& line, const ScanImage* scan)
    : data_(data),
      line_(line),
      scan_(scan),
      renderer_(vtkSmartPointer<vtkRenderer>::New()),
      still_lumen_(data.lumen),
      lumen_(detail::colors::kLumen),
      wall_(detail::colors::kLumen),
      balloon_(detail::colors::kBalloon) {
  renderer_->SetBackground(0.075, 0.085, 0.105);
  if (!data.frames.empty()) {
    first_wall_ = formats::read_surface(data.frames.front().vessel).mesh;
    still_lumen_ = detail::surroundings(data.lumen, first_wall_, {}, kInfinity);
  }
  whole_lumen_ = shaded(still_lumen_);
  thin_lumen_ = thinned(whole_lumen_);
  lumen_.set_input(thin_lumen_);
  wire_tube_->SetRadius(kWireRadiusMm);
  wire_tube_->SetNumberOfSides(12);
  wire_tube_->CappingOn();
  set_color(wire_, kWireColor);
  wire_->VisibilityOff();

  // What is opaque comes first by itself; of the rest VTK keeps this order.
  lumen_.add_far_side(renderer_);
  wall_.add_far_side(renderer_);
  renderer_->AddActor(wire_);
  if (scan) renderer_->AddViewProp(slice_);
  add_lines();
  balloon_.add_far_side(renderer_);
  balloon_.add_near_side(renderer_);
  wall_.add_near_side(renderer_);
  lumen_.add_near_side(renderer_);

  opacity_.fill(1.0);
  set_opacity(Layer::lumen, 0.4);
  set_opacity(Layer::wall, 0.4);
  vtkNew<vtkPolyDataMapper> ring;
  ring->SetInputConnection(cursor_ring_->GetOutputPort());
  cursor_ring_->GeneratePolygonOff();
  cursor_ring_->SetNumberOfSides(72);
  cursor_->SetMapper(ring);
  cursor_->GetProperty()->SetColor(1.0, 0.86, 0.2);
  cursor_->GetProperty()->SetLineWidth(3.0f);
  cursor_->GetProperty()->LightingOff();
  cursor_->VisibilityOff();  // until it has a place
  renderer_->AddActor(cursor_);
  if (scan) {
    slice_mapper_->SetInputData(scan->image);
    slice_->SetMapper(slice_mapper_);
    slice_->SetProperty(scan->look);
    slice_->SetUserMatrix(scan->lps_from_image);
    slice_->VisibilityOff();
    add_projection(*scan);
  }
  words_ = detail::make_text("", 15, detail::colors::kLightInk);
  words_->GetTextProperty()->SetVerticalJustificationToTop();
  words_->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  words_->SetPosition(0.012, 0.985);
  renderer_->AddActor2D(words_);
  scale_bar_ = std::make_unique<detail::ScaleBar>(renderer_, 1, detail::colors::kLightInk);
  look_at_tree(1.5);
}

void SceneView::add_lines() {
  if (data_.paths.empty()) return;
  double widest = 0.0;
  for (const double radius : line_.path.inscribed_radius) widest = std::max(widest, radius);
  vtkNew<vtkTubeFilter> tubes;
  tubes->SetInputData(each_stretch_once(data_.paths));
  tubes->SetRadius(std::max(0.04 * widest, 1e-3));
  tubes->SetNumberOfSides(6);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(tubes->GetOutputPort());
  mapper->ScalarVisibilityOff();
  lines_ = vtkSmartPointer<vtkActor>::New();
  lines_->SetMapper(mapper);
  set_color(lines_, detail::colors::kCenterline);
  renderer_->AddActor(lines_);
}

void SceneView::add_projection(const ScanImage& scan) {
  projection_ = make_projection_volume(scan);
  projection_->VisibilityOff();
  renderer_->AddViewProp(projection_);
}

void SceneView::show_frame(const FrameShapes& shapes) {
  shapes_ = shapes;
  paint();
}

void SceneView::keep_clear(int bottom_pixels) {
  clear_ = bottom_pixels;
  color_by(field_, field_range_);
}

void SceneView::color_by(const std::optional<Field>& field, const FieldRange& range) {
  for (const auto& part : color_bar_) renderer_->RemoveViewProp(part);
  color_bar_.clear();
  field_ = field;
  field_range_ = range;
  if (field) {
    colors_ = field->array == "contact_pressure"
                  ? detail::make_pressure_colors(range.high)
                  : detail::make_thickness_colors(range.low, range.high);
    color_bar_ =
        detail::add_color_bar(renderer_, colors_, field->title(),
                              {24.0, 84.0 + clear_, 250.0, 12.0}, 1, detail::colors::kLightInk);
  }
  paint();
}

void SceneView::paint() {
  const bool shows_tissue = field_ && field_->body == Body::tissue && shapes_.tissue;
  wall_.set_input(shows_tissue ? shapes_.tissue : shapes_.wall);
  balloon_.set_input(shapes_.balloon);
  const auto map_for = [&](bool is_meant) { return field_ && is_meant ? colors_.Get() : nullptr; };
  const char* array = field_ ? field_->array.c_str() : "";
  const bool is_on_cells = field_ && field_->is_on_cells;
  wall_.color_by(array, is_on_cells, map_for(field_ && field_->body != Body::balloon));
  balloon_.color_by(array, is_on_cells, map_for(field_ && field_->body == Body::balloon));
  if (!shapes_.wire) return;
  wire_tube_->SetInputData(shapes_.wire);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(wire_tube_->GetOutputPort());
  mapper->ScalarVisibilityOff();
  if (!wire_->GetMapper()) wire_->VisibilityOn();
  wire_->SetMapper(mapper);
}

TwoSidedSurface* SceneView::surface(Layer layer) {
  return const_cast<TwoSidedSurface*>(std::as_const(*this).surface(layer));
}

const TwoSidedSurface* SceneView::surface(Layer layer) const {
  if (layer == Layer::lumen) return &lumen_;
  if (layer == Layer::wall) return &wall_;
  return layer == Layer::balloon ? &balloon_ : nullptr;
}

vtkProp* SceneView::prop(Layer layer) const {
  if (layer == Layer::wire) return wire_;
  if (layer == Layer::line) return lines_;
  if (layer == Layer::slice) return slice_;
  return layer == Layer::projection ? projection_.Get() : nullptr;
}

bool SceneView::has(Layer layer) const {
  switch (layer) {
    case Layer::lumen:
      return true;
    case Layer::line:
      return lines_ != nullptr;
    case Layer::slice:
    case Layer::projection:
      return scan_ != nullptr;
    default:
      return !data_.frames.empty();
  }
}

bool SceneView::is_visible(Layer layer) const {
  if (!has(layer)) return false;
  if (const TwoSidedSurface* body = surface(layer)) return body->is_visible();
  return prop(layer)->GetVisibility() != 0;
}

void SceneView::set_visible(Layer layer, bool is_visible) {
  if (!has(layer)) return;
  if (TwoSidedSurface* body = surface(layer)) return body->set_visible(is_visible);
  prop(layer)->SetVisibility(is_visible ? 1 : 0);
}

double SceneView::opacity(Layer layer) const { return opacity_[place(layer)]; }

void SceneView::set_opacity(Layer layer, double opacity) {
  opacity_[place(layer)] = std::clamp(opacity, 0.0, 1.0);
  const double value = opacity_[place(layer)];
  if (TwoSidedSurface* body = surface(layer)) return body->set_opacity(value);
  if (layer == Layer::wire) wire_->GetProperty()->SetOpacity(value);
  if (layer == Layer::line && lines_) lines_->GetProperty()->SetOpacity(value);
  if (layer == Layer::slice && scan_) {
    vtkNew<vtkImageProperty> own;  // the panels' slices stay opaque
    own->DeepCopy(scan_->look);
    own->SetOpacity(value);
    slice_->SetProperty(value < 1.0 ? own.Get() : scan_->look.Get());
  }
  if (layer == Layer::projection && projection_) set_projection_opacity(projection_, value);
}

void SceneView::set_drawn(Drawn drawn) {
  lumen_.set_input(drawn == Drawn::as_wireframe ? whole_lumen_ : thin_lumen_);
  for (TwoSidedSurface* body : {&lumen_, &wall_, &balloon_}) body->set_drawn(drawn);
}

void SceneView::set_clipping(vtkPlane* plane) {
  lumen_.set_clipping(plane);
  wall_.set_clipping(plane);
}

void SceneView::set_cursor(double abscissa_mm) {
  cursor_->VisibilityOn();
  const CenterlineSample place_on_line = sample(line_.path, abscissa_mm);
  const Vec3& point = place_on_line.point;
  const Vec3& normal = place_on_line.tangent;
  cursor_ring_->SetCenter(point.x, point.y, point.z);
  cursor_ring_->SetNormal(normal.x, normal.y, normal.z);
  cursor_ring_->SetRadius(
      1.3 * std::max(place_on_line.inscribed_radius, 0.5 * line_.widest_mm(abscissa_mm)));
}

void SceneView::set_words(const std::string& words) { words_->SetInput(words.c_str()); }

void SceneView::set_slice(int axis, const Vec3& point) {
  if (!scan_) return;
  const double in_lps[4] = {point.x, point.y, point.z, 1.0};
  vtkNew<vtkMatrix4x4> image_from_lps;
  vtkMatrix4x4::Invert(scan_->lps_from_image, image_from_lps);
  double in_image[4];
  image_from_lps->MultiplyPoint(in_lps, in_image);
  slice_mapper_->SetOrientation(axis);
  slice_mapper_->SetSliceNumber(
      int(std::lround(in_image[axis] / scan_->image->GetSpacing()[axis])));
}

Vec3 SceneView::point_of_interest() const {
  return detail::bounds(first_wall_.vertices.empty() ? data_.lumen : first_wall_).center;
}

double SceneView::reach_mm() const {
  return detail::bounds(first_wall_.vertices.empty() ? data_.lumen : first_wall_).radius_mm;
}

std::vector<vtkActor*> SceneView::surfaces() {
  return {lumen_.picked_actor(), wall_.picked_actor()};
}

void SceneView::look_at_lesion(double aspect) {
  if (first_wall_.vertices.empty() || !line_.exists()) return look_at_tree(aspect);
  const Vec3 point = point_of_interest();
  detail::ViewFrame frame =
      detail::frame_lesion(first_wall_, still_lumen_, line_.path, project(line_.path, point));
  constexpr double kRoom = 1.35;
  frame.half_width_mm *= kRoom;
  frame.half_height_mm *= kRoom;
  detail::aim(renderer_, frame, aspect);
}

void SceneView::look_at_tree(double aspect) {
  detail::ViewFrame frame = detail::frame_tree(data_.lumen);
  constexpr double kRoom = 1.15;
  frame.half_width_mm *= kRoom;
  frame.half_height_mm *= kRoom;
  detail::aim(renderer_, frame, aspect);
}

}  // namespace angio::viewer::window
