#include "viewer/window/views.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/text.hpp"
#include "viewer/detail/report_charts.hpp"
#include "viewer/detail/view_frame.hpp"
#include "viewer/window/colors.hpp"
#include "viewer/window/legend.hpp"

namespace angio::viewer::window {
namespace fs = std::filesystem;
namespace {

constexpr double kSlabMm = 20.0;
constexpr double kSectionMm = 5.0;   // shown above and below the line
constexpr double kSliceReach = 1.3;  // of what the balloon touches

struct AxisView {
  const char* name;
  Vec3 direction, up;
  std::array<std::string, 4> letters;  ///< left, right, top, bottom
  const char* coordinate;
  int component;
};

/// As radiologists look: from the feet, from the front, from the patient's left.
const AxisView& view_of(SliceAxis axis) {
  static const std::array<AxisView, 3> kViews = {
      AxisView{"axial", {0, 0, 1}, {0, -1, 0}, {"R", "L", "A", "P"}, "H", 2},
      AxisView{"coronal", {0, 1, 0}, {0, 0, 1}, {"R", "L", "H", "F"}, "P", 1},
      AxisView{"sagittal", {-1, 0, 0}, {0, 0, 1}, {"A", "P", "H", "F"}, "L", 0},
  };
  return kViews[std::size_t(axis)];
}

/// The axis of the voxels that runs most along a direction.
int voxel_axis(const VolumeGeometry& grid, const Vec3& direction) {
  const Vec3 along = transpose(grid.direction) * direction;
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(along[a]) > std::abs(along[axis])) axis = a;
  return axis;
}

}  // namespace

Views::Views(const fs::path& case_folder)
    : folder_(case_folder),
      simulation_(detail::simulation_folder(case_folder)),
      data_(detail::read_case(case_folder)),
      line_(read_treated_line(case_folder, data_)),
      store_(data_) {
  if (data_.scan) scan_ = make_scan_image(*data_.scan);
  const ScanImage* scan = scan_ ? &*scan_ : nullptr;
  scene_ = std::make_unique<SceneView>(data_, line_, scan);
  slice_ = std::make_unique<ImagePanel>(scan, kSliceReach * scene_->reach_mm());
  section_ = std::make_unique<ImagePanel>(scan, kSectionMm);
  add_legend(section_->renderer(), 0.42, 0.975,
             {{"before", colors::kBefore},
              {"now", colors::kNow},
              {"after", colors::kAfter},
              {"balloon", colors::kBalloon}});
  fields_ = store_.fields();
  abscissa_mm_ = line_.start_mm();
  slice_point_ =
      line_.exists() ? sample(line_.path, abscissa_mm_).point : scene_->point_of_interest();
  add_diameters();
  if (!data_.frames.empty()) show_frame(detail::peak_frame(data_));
  show_contours();
  walk_to(abscissa_mm_);
  set_slice_axis(SliceAxis::axial);
}

void Views::add_diameters() {
  curve_ = std::make_unique<DiameterCurve>(line_);
  curve_->set_cursor(abscissa_mm_);
}

bool Views::reload_frames() {
  const fs::path simulation = detail::simulation_folder(folder_);
  std::error_code ignored;
  if (simulation != simulation_ || data_.frames.empty() ||
      fs::exists(simulation / "lumen_profile.csv", ignored))
    return false;
  data_.frames = detail::read_frame_list(simulation / "simulation.pvd");
  if (fs::exists(simulation / "timeseries.csv", ignored))
    data_.series = detail::read_time_series(simulation / "timeseries.csv");
  show_frame(frame_);
  return true;
}

void Views::show_frame(std::size_t index) {
  if (data_.frames.empty()) return;
  frame_ = std::min(index, data_.frames.size() - 1);
  scene_->show_frame(store_.at(frame_));
  show_contours();
}

double Views::time_s() const { return data_.frames.empty() ? 0.0 : data_.frames[frame_].time_s; }

std::size_t Views::frame_at(double time_s) const {
  std::size_t index = 0;
  while (index + 1 < data_.frames.size() && data_.frames[index + 1].time_s <= time_s + 1e-9)
    ++index;
  return index;
}

double Views::number(const char* name) const {
  if (data_.frames.empty()) return kUnknown;
  const auto row = detail::row_of(data_.series, data_.frames[frame_].frame);
  const std::vector<double> values = detail::column(data_.series, name);
  return row && *row < values.size() ? values[*row] : kUnknown;
}

std::string Views::phase() const {
  if (data_.frames.empty()) return "";
  const auto row = detail::row_of(data_.series, data_.frames[frame_].frame);
  const auto& columns = data_.series.columns;
  const auto place =
      std::size_t(std::find(columns.begin(), columns.end(), "phase") - columns.begin());
  return row && place < data_.series.rows[*row].size() ? data_.series.rows[*row][place] : "";
}

double Views::highest_pressure_atm() const {
  double highest = 0.0;
  for (const double pressure : detail::column(data_.series, "pressure_atm"))
    if (std::isfinite(pressure)) highest = std::max(highest, pressure);
  return highest;
}

void Views::color_by(std::optional<std::size_t> place) {
  field_ = place && *place < fields_.size() ? place : std::nullopt;
  if (!field_) {
    if (plain_wall_opacity_) scene_->set_opacity(Layer::wall, *plain_wall_opacity_);
    plain_wall_opacity_.reset();
    return scene_->color_by(std::nullopt, {});
  }
  // Colours are read against the bar: nothing may tint them.
  constexpr double kFaint = 0.12;
  if (!plain_wall_opacity_) plain_wall_opacity_ = scene_->opacity(Layer::wall);
  const bool is_balloon = fields_[*field_].body == Body::balloon;
  scene_->set_opacity(Layer::wall, is_balloon ? kFaint : 1.0);
  scene_->color_by(fields_[*field_], store_.range(fields_[*field_]));
}

void Views::walk_to(double abscissa_mm) {
  if (!line_.exists()) return;
  abscissa_mm_ = std::clamp(abscissa_mm, 0.0, line_.length_mm());
  const CenterlineSample place = sample(line_.path, abscissa_mm_);
  scene_->set_cursor(abscissa_mm_);
  curve_->set_cursor(abscissa_mm_);
  slice_point_ = place.point;
  show_slice(true);
  show_section();
}

void Views::walk_to_point(const Vec3& point) {
  if (line_.exists()) walk_to(project(line_.path, point));
}

void Views::set_slice_axis(SliceAxis axis) {
  axis_ = axis;
  show_slice(true);
}

void Views::center_panels() {
  slice_->set_half_height(kSliceReach * scene_->reach_mm());
  section_->set_half_height(kSectionMm);
  show_slice(true);
  if (line_.exists()) walk_to(abscissa_mm_);
}

void Views::scroll_slice(int steps) {
  const double step_mm = scan_ ? scan_->voxel_mm : 0.5;
  slice_point_ += (steps * step_mm) * view_of(axis_).direction;
  show_slice(false);
}

void Views::set_slab(bool is_slab) {
  is_slab_ = is_slab;
  slice_->set_slab(is_slab ? kSlabMm : 0.0);
  show_slice(false);
}

void Views::change_grey(double window_by, double level_by) {
  if (!scan_) return;
  const double unit = 0.01 * (scan_->white - scan_->black);
  const double window = scan_->look->GetColorWindow() + window_by * unit;
  scan_->look->SetColorWindow(std::max(window, unit));
  scan_->look->SetColorLevel(scan_->look->GetColorLevel() + level_by * unit);
  show_slice(false);
}

void Views::reset_grey() {
  if (!scan_) return;
  scan_->look->SetColorWindow(scan_->white - scan_->black);
  scan_->look->SetColorLevel(0.5 * (scan_->white + scan_->black));
  show_slice(false);
}

std::string Views::grey_words() const {
  if (!scan_) return "no scan";
  return "W " + formats::fixed_text(scan_->look->GetColorWindow(), 0) + "  L " +
         formats::fixed_text(scan_->look->GetColorLevel(), 0);
}

void Views::show_slice(bool is_new) {
  const AxisView& view = view_of(axis_);
  slice_->look_at({slice_point_, view.direction, view.up, is_new});
  slice_->set_edge_letters(view.letters);
  slice_->set_words(std::string(view.name) + "  " + view.coordinate + " = " +
                        formats::fixed_text(slice_point_[view.component], 1) + " mm" +
                        (is_slab_ ? ", brightest of 20 mm" : ""),
                    grey_words());
  if (data_.scan) scene_->set_slice(voxel_axis(data_.scan->geometry, view.direction), slice_point_);
}

void Views::show_section() {
  const CenterlineSample place = sample(line_.path, abscissa_mm_);
  // The same way up along the whole line: the head, or, where the line runs along it, the front.
  Vec3 up{0, 0, 1};
  if (std::abs(dot(up, place.tangent)) > 0.9) up = {0, -1, 0};
  up = normalized(up - dot(up, place.tangent) * place.tangent);
  section_->look_at({place.point, place.tangent, up, true});
  section_->set_words("section at " + formats::fixed_text(abscissa_mm_, 1) + " mm", "");
}

void Views::show_contours() {
  if (data_.frames.empty()) {
    slice_->set_contours({{&data_.lumen, colors::kBefore}});
    section_->set_contours({{&data_.lumen, colors::kBefore}});
    return;
  }
  const FrameShapes& now = store_.at(frame_);
  section_->set_contours({{&data_.lumen, colors::kBefore},
                          {&store_.at(data_.frames.size() - 1).wall_mesh, colors::kAfter},
                          {&now.wall_mesh, colors::kNow},
                          {&now.balloon_mesh, colors::kBalloon}});
  slice_->set_contours({{&data_.lumen, colors::kBefore},
                        {&now.wall_mesh, colors::kNow},
                        {&now.balloon_mesh, colors::kBalloon}});
}

}  // namespace angio::viewer::window
