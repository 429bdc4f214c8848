#include "viewer/detail/course.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "viewer/detail/pictures_3d.hpp"
#include "viewer/detail/report_charts.hpp"

namespace angio::viewer::detail {
namespace case_file = formats::case_file;
namespace fs = std::filesystem;
namespace {

constexpr const char* kContactPressure = "contact_pressure";

/// Where the balloon lies; without its file no line is known, and the view is the tree's.
void read_place(const fs::path& placement, ReportContent& content) {
  content.lesion_path = -1;
  std::error_code ignored;
  if (!fs::exists(placement, ignored)) return;
  const auto json = nlohmann::json::parse(read_text(placement), nullptr, false);
  if (json.is_discarded() || !json.contains("lesion"))
    throw InputError(placement.string() +
                     " is damaged (it names no lesion). Run `angio mesh CASE` again");
  content.lesion_path = json["lesion"].value("centerline_id", -1);
  content.lesion_abscissa_mm = json["lesion"].value("abscissa_mm", 0.0);
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double middle() const { return 0.5 * (low + high); }
  [[nodiscard]] double half() const { return 0.5 * (high - low); }
};

}  // namespace

Moment read_moment(const FrameFiles& files) {
  Moment moment;
  moment.balloon = formats::read_surface(files.balloon).mesh;
  formats::SurfaceData wall = formats::read_surface(files.vessel);
  for (DataArray& array : wall.point_arrays)
    if (array.name == kContactPressure) moment.contact_pressure_kpa = std::move(array.values);
  moment.wall = std::move(wall.mesh);
  moment.contact_pressure_kpa.resize(moment.wall.vertices.size(), 0.0);
  if (!files.guidewire.empty()) moment.guidewire = formats::read_polylines(files.guidewire).points;
  return moment;
}

Course read_course(const fs::path& case_folder) {
  Course course;
  course.data = read_case(case_folder);
  if (course.data.frames.empty())
    throw InputError(
        case_folder.string() +
            " has no balloon in a vessel to show (there are no frames of a simulation, "
            "which ended before or was not run). Run `angio simulate " +
            case_folder.string() + "` first",
        ExitCode::no_input);
  course.peak = peak_frame(course.data);
  ReportContent& content = course.content;
  content.lumen = course.data.lumen;
  content.tree.paths = course.data.paths;
  content.time_series = course.data.series;
  read_place(case_folder / case_file::kPlacement, content);
  const auto& frames = course.data.frames;
  content.moments = {read_moment(frames.front()), read_moment(frames[course.peak]),
                     read_moment(frames.back())};
  return course;
}

double value_at(const Course& course, const FrameFiles& files, const std::string& name) {
  const auto row = row_of(course.data.series, files.frame);
  const std::vector<double> values = column(course.data.series, name);
  return row && *row < values.size() ? values[*row] : std::numeric_limits<double>::quiet_NaN();
}

ViewFrame balloon_frame(const ReportContent& content) {
  constexpr double kMargin = 1.25;
  ViewFrame frame = close_up_frame(content);
  Range along, across;
  for (const Moment& moment : content.moments)
    for (const Vec3& point : moment.balloon.vertices) {
      along.take(dot(point - frame.focus, frame.right()));
      across.take(dot(point - frame.focus, frame.up));
    }
  if (!(along.half() > 0.0)) return frame;
  for (const Moment& moment : content.moments)
    for (const Vec3& point : moment.wall.vertices)
      if (const double x = dot(point - frame.focus, frame.right());
          x >= along.low && x <= along.high)
        across.take(dot(point - frame.focus, frame.up));
  frame.focus += along.middle() * frame.right() + across.middle() * frame.up;
  frame.half_width_mm = kMargin * along.half();
  frame.half_height_mm = kMargin * across.half();
  return frame;
}

}  // namespace angio::viewer::detail
