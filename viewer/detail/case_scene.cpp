#include "viewer/detail/case_scene.hpp"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPlaneSource.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>
#include <vtkTexture.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "formats/files.hpp"
#include "viewer/detail/plane.hpp"
#include "viewer/detail/view_frame.hpp"

namespace angio::viewer::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Every so-manyth voxel is enough to choose black and white.
std::vector<float> thinned(const std::vector<float>& values) {
  constexpr std::size_t kEnough = 500'000;
  const std::size_t stride = 1 + values.size() / kEnough;
  std::vector<float> few;
  for (std::size_t i = 0; i < values.size(); i += stride) few.push_back(values[i]);
  return few;
}

struct GreyRange {
  double black = 0.0;
  double white = 1.0;
};

/// One slice of the scan as a textured rectangle. Bright voxels are more opaque, so that the slices
/// do not hide what lies behind air or dark tissue. (VTK's own image slices do not take part in
/// depth peeling, and would hide the translucent lumen.)
vtkSmartPointer<vtkActor> make_slice(const Volume<float>& volume, int axis, int index,
                                     const GreyRange& range) {
  const VolumeGeometry& grid = volume.geometry;
  const int axis_u = (axis + 1) % 3, axis_v = (axis + 2) % 3;
  const int size_u = grid.size[std::size_t(axis_u)], size_v = grid.size[std::size_t(axis_v)];
  vtkNew<vtkImageData> image;
  image->SetDimensions(size_u, size_v, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  auto* pixel = static_cast<unsigned char*>(image->GetScalarPointer());
  std::array<int, 3> voxel{};
  voxel[std::size_t(axis)] = index;
  for (int v = 0; v < size_v; ++v)
    for (int u = 0; u < size_u; ++u) {
      voxel[std::size_t(axis_u)] = u;
      voxel[std::size_t(axis_v)] = v;
      const double value = volume.at(voxel[0], voxel[1], voxel[2]);
      const double shade =
          std::clamp((value - range.black) / (range.white - range.black), 0.0, 1.0);
      for (int c = 0; c < 3; ++c) *pixel++ = static_cast<unsigned char>(255.0 * shade);
      *pixel++ = static_cast<unsigned char>(255.0 * (0.12 + 0.48 * shade));
    }

  const auto corner = [&](double u, double v) {  // the outer edges of the voxels
    Vec3 place;
    place[axis] = index;
    place[axis_u] = u - 0.5;
    place[axis_v] = v - 0.5;
    return grid.lps_from_index(place);
  };
  const Vec3 origin = corner(0, 0), along_u = corner(size_u, 0), along_v = corner(0, size_v);
  vtkNew<vtkPlaneSource> plane;
  plane->SetOrigin(origin.x, origin.y, origin.z);
  plane->SetPoint1(along_u.x, along_u.y, along_u.z);
  plane->SetPoint2(along_v.x, along_v.y, along_v.z);
  plane->Update();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(plane->GetOutput());
  vtkNew<vtkTexture> texture;
  texture->SetInputData(image);
  texture->InterpolateOn();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->SetTexture(texture);
  actor->GetProperty()->LightingOff();
  actor->ForceTranslucentOn();
  return actor;
}

void move(vtkSmartPointer<vtkActor>& actor, vtkRenderer* renderer,
          const vtkSmartPointer<vtkActor>& replacement) {
  const bool was_visible = !actor || actor->GetVisibility();
  if (actor) renderer->RemoveActor(actor);
  actor = replacement;
  actor->SetVisibility(was_visible ? 1 : 0);
  renderer->AddActor(actor);
}

std::vector<double> pressure_of(const formats::SurfaceData& vessel) {
  const auto found =
      std::find_if(vessel.point_arrays.begin(), vessel.point_arrays.end(),
                   [](const DataArray& array) { return array.name == "contact_pressure"; });
  return found == vessel.point_arrays.end() ? std::vector<double>() : found->values;
}

}  // namespace

CaseScene::CaseScene(const CaseData& data, int scale)
    : data_(data), scale_(scale), renderer_(vtkSmartPointer<vtkRenderer>::New()) {
  renderer_->SetBackground(0.075, 0.085, 0.105);
  still_lumen_ = data.lumen;
  if (!data.frames.empty()) {
    first_wall_ = formats::read_surface(data.frames.front().vessel).mesh;
    still_lumen_ = surroundings(data.lumen, first_wall_, {}, kInfinity);
    add_pressure_colors();
  }
  if (data.scan) add_scan(point_of_interest());
  lumen_ = make_surface(still_lumen_, {colors::kLumen, data.frames.empty() ? 0.5 : 0.35});
  renderer_->AddActor(lumen_);
  for (const CenterlinePath& path : data.paths) {
    const double thickness =
        0.06 * *std::max_element(path.inscribed_radius.begin(), path.inscribed_radius.end());
    lines_.push_back(make_tube(path.points, std::max(thickness, 1e-3), colors::kCenterline));
    renderer_->AddActor(lines_.back());
  }
  add_texts(scale);
  look_at_tree(1.5);
  axes_ = make_axes(scale, colors::kLightInk);
}

void CaseScene::add_scan(const Vec3& center) {
  const VolumeGeometry& grid = data_.scan->geometry;
  const std::vector<float> few = thinned(data_.scan->values);
  GreyRange range{percentile(few, 0.01), percentile(few, 0.997)};
  if (range.white <= range.black) range.white = range.black + 1.0;
  const Vec3 index = grid.index_from_lps(center);
  for (int axis = 0; axis < 3; ++axis) {
    const double last = double(grid.size[std::size_t(axis)] - 1);
    const int slice = int(std::clamp(std::round(index[axis]), 0.0, last));
    slices_.push_back(make_slice(*data_.scan, axis, slice, range));
    renderer_->AddActor(slices_.back());
  }
}

void CaseScene::add_texts(int scale) {
  status_ = make_text(data_.frames.empty() ? "not dilated yet" : "", 16 * scale, colors::kLightInk);
  status_->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  status_->SetPosition(0.012, 0.962);
  renderer_->AddActor2D(status_);
  const auto help = make_text(
      "drag: rotate    wheel: zoom    space: play    arrows: step    s scan    l lumen    "
      "c centreline    p contact pressure    b balloon    t whole tree    q quit",
      12 * scale, colors::kLightInk);
  help->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  help->SetPosition(0.012, 0.935);
  renderer_->AddActor2D(help);
  scale_bar_ = std::make_unique<ScaleBar>(renderer_, scale, colors::kLightInk);
}

std::vector<vtkRenderer*> CaseScene::layers() const { return {renderer_, axes_}; }

void CaseScene::show_frame(std::size_t index) {
  if (index >= data_.frames.size()) return;
  frame_ = index;
  const FrameFiles& files = data_.frames[index];
  const formats::SurfaceData vessel = formats::read_surface(files.vessel);
  contact_pressure_kpa_ = pressure_of(vessel);
  for (const auto& actor : balloon_) renderer_->RemoveActor(actor);
  balloon_ =
      make_balloon(formats::read_surface(files.balloon).mesh,
                   files.guidewire.empty() ? std::vector<Vec3>()
                                           : formats::read_polylines(files.guidewire).points);
  for (const auto& actor : balloon_) renderer_->AddActor(actor);
  move(wall_, renderer_, make_surface(vessel.mesh, {colors::kLumen, 0.38}));
  if (shows_pressure_) color_wall();
  status_->SetInput(describe_frame(data_, files).c_str());
}

void CaseScene::color_wall() {
  if (contact_pressure_kpa_.empty()) return;
  color_by(wall_, contact_pressure_kpa_, pressure_colors_);
  wall_->GetProperty()->SetOpacity(1.0);
}

void CaseScene::add_pressure_colors() {
  double highest = 0.0;
  for (const double p : pressure_of(formats::read_surface(data_.frames[peak_frame(data_)].vessel)))
    highest = std::max(highest, p);
  pressure_colors_ = make_pressure_colors(highest > 0.0 ? highest : 1.0);
  const double unit = scale_;
  color_bar_ = add_color_bar(renderer_, pressure_colors_, "contact pressure [kPa]",
                             {24.0 * unit, 84.0 * unit, 250.0 * unit, 12.0 * unit}, scale_,
                             colors::kLightInk);
  for (const auto& part : color_bar_) part->VisibilityOff();
}

void CaseScene::toggle(ScenePart part) {
  const auto flip = [](vtkProp* prop) { prop->SetVisibility(prop->GetVisibility() ? 0 : 1); };
  switch (part) {
    case ScenePart::scan:
      for (const auto& slice : slices_) flip(slice);
      break;
    case ScenePart::lumen:
      flip(lumen_);
      if (wall_) flip(wall_);
      break;
    case ScenePart::centerline:
      for (const auto& line : lines_) flip(line);
      break;
    case ScenePart::pressure:
      shows_pressure_ = !shows_pressure_;
      for (const auto& part_of_bar : color_bar_) flip(part_of_bar);
      show_frame(frame_);
      break;
  }
}

Vec3 CaseScene::point_of_interest() const {
  return bounds(first_wall_.vertices.empty() ? data_.lumen : first_wall_).center;
}

void CaseScene::look_at_lesion(double aspect) {
  if (first_wall_.vertices.empty() || data_.paths.empty()) return look_at_tree(aspect);
  const Vec3 point = point_of_interest();
  const CenterlinePath* nearest = nullptr;
  double nearest_distance = kInfinity;
  for (const CenterlinePath& path : data_.paths) {
    const double gap = distance(sample(path, project(path, point)).point, point);
    if (gap < nearest_distance) {
      nearest_distance = gap;
      nearest = &path;
    }
  }
  ViewFrame frame = frame_lesion(first_wall_, still_lumen_, *nearest, project(*nearest, point));
  constexpr double kRoom = 1.35;
  frame.half_width_mm *= kRoom;
  frame.half_height_mm *= kRoom;
  aim(renderer_, frame, aspect);
}

void CaseScene::look_at_tree(double aspect) {
  ViewFrame frame = frame_tree(data_.lumen);
  constexpr double kRoom = 1.15;
  frame.half_width_mm *= kRoom;
  frame.half_height_mm *= kRoom;
  aim(renderer_, frame, aspect);
}

void CaseScene::update_overlays() {
  scale_bar_->update();
  const int* size = renderer_->GetSize();
  if (size[0] > 0 && size[1] > 0) turn_axes(axes_, renderer_, size[0] / scale_, size[1] / scale_);
}

}  // namespace angio::viewer::detail
