#include "pipeline/stages/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "formats/case_file.hpp"
#include "formats/csv.hpp"
#include "formats/files.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/doubts.hpp"
#include "pipeline/case/flow.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/case/working_view.hpp"
#include "pipeline/stages/report_views.hpp"
#include "pipeline/version.hpp"
#include "segmentation/read_volume.hpp"
#include "viewer/report.hpp"

// From what the stages have left to the report.
namespace angio::pipeline {
namespace file = formats::case_file;
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

/// @param when  as in the columns' names
viewer::DiameterProfile read_profile(const formats::CsvTable& table, const std::string& when) {
  return {table.numbers("abscissa_mm"), table.numbers("inscribed_diameter_" + when + "_mm"),
          table.numbers("equivalent_diameter_" + when + "_mm")};
}

/// The written frames. @throws InputError if the peak or the last is not among them
std::vector<viewer::FrameTime> read_frame_times(const StageFiles& files, const json& summary) {
  std::vector<viewer::FrameTime> frames = viewer::read_frame_times(files.path(file::kFrameList));
  for (const char* key : {"peak_frame", "last_frame"}) {
    const int frame = summary.at(key).get<int>();
    if (std::none_of(frames.begin(), frames.end(),
                     [&](const viewer::FrameTime& f) { return f.frame == frame; }))
      throw InputError(
          fmt::format("simulation.pvd does not list frame {}, summary.json's {} (a "
                      "file was changed or is damaged). Run `angio simulate` again",
                      frame, key));
  }
  return frames;
}

/// The shapes of the frames that the report shows, each read once.
class Shapes {
 public:
  Shapes(const StageFiles& files, const std::set<int>& frames) {
    const std::vector<int> list(frames.begin(), frames.end());
    std::vector<FrameShape> shapes = read_frames(files.path(file::kFrames), list);
    const bool rests = !shapes.empty() && shapes.front().guidewire.empty();
    const std::vector<Vec3> resting_wire =
        rests ? formats::read_polylines(files.path(file::kGuidewire)).points : std::vector<Vec3>();
    for (std::size_t n = 0; n < list.size(); ++n) {
      if (rests) shapes[n].guidewire = resting_wire;
      shapes_.emplace(list[n], std::move(shapes[n]));
    }
  }
  [[nodiscard]] viewer::Moment at(int frame, std::string title) const {
    const FrameShape& shape = shapes_.at(frame);
    return {std::move(title), shape.balloon, shape.wall, shape.contact_pressure_kpa,
            shape.guidewire};
  }

 private:
  std::map<int, FrameShape> shapes_;
};

/// Which of the written frames the report shows.
struct ShownFrames {
  int peak = 0, last = 0;
  std::vector<viewer::FrameTime> sequence;
  std::vector<viewer::FrameTime> course;  ///< from the first to the last, evenly, with the peak

  [[nodiscard]] std::set<int> all() const {
    std::set<int> frames{0, peak, last};
    for (const auto* some : {&sequence, &course})
      for (const viewer::FrameTime& at : *some) frames.insert(at.frame);
    return frames;
  }
};

std::vector<viewer::FrameTime> course_of(const std::vector<viewer::FrameTime>& frames,
                                         const viewer::FrameTime& peak) {
  constexpr std::size_t kMostFrames = 40;
  const std::size_t steps = std::min(frames.size(), kMostFrames) - 1;
  std::vector<viewer::FrameTime> course;
  for (std::size_t i = 0; i <= steps; ++i)
    course.push_back(frames[steps == 0 ? 0 : i * (frames.size() - 1) / steps]);
  *std::min_element(course.begin(), course.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.frame - peak.frame) < std::abs(b.frame - peak.frame);
  }) = peak;
  return course;
}

ShownFrames choose_frames(const StageFiles& files, const json& summary) {
  const std::vector<viewer::FrameTime> frames = read_frame_times(files, summary);
  ShownFrames shown{
      summary.at("peak_frame").get<int>(), summary.at("last_frame").get<int>(), {}, {}};
  const auto peak = std::find_if(frames.begin(), frames.end(),
                                 [&](const auto& f) { return f.frame == shown.peak; });
  for (const std::size_t place :
       viewer::sequence_places(frames.size(), std::size_t(peak - frames.begin())))
    shown.sequence.push_back(frames[place]);
  shown.course = course_of(frames, *peak);
  return shown;
}

std::vector<viewer::Moment> moments_of(const Shapes& shapes, const ShownFrames& shown,
                                       const json& summary) {
  const double peak_pressure = summary.at("balloon").at("peak_pressure_atm").get<double>();
  return {shapes.at(0, "Before"),
          shapes.at(shown.peak, fmt::format("At peak, {:.1f} atm", peak_pressure)),
          shapes.at(shown.last, "After")};
}

std::vector<viewer::Moment> sequence_of(const Shapes& shapes, const ShownFrames& shown) {
  std::vector<viewer::Moment> sequence;
  for (const viewer::FrameTime& at : shown.sequence)
    sequence.push_back(shapes.at(
        at.frame, fmt::format("({}) {:.3f} s", char('a' + int(sequence.size())), at.time_s)));
  return sequence;
}

std::vector<viewer::CourseFrame> course_of(const Shapes& shapes, const ShownFrames& shown,
                                           const formats::CsvTable& series) {
  const std::vector<double> pressure = series.numbers("pressure_atm");
  const std::vector<std::string> phase = series.texts("phase");
  std::vector<viewer::CourseFrame> course;
  for (const viewer::FrameTime& at : shown.course) {
    const auto row = std::size_t(at.frame);
    if (row >= pressure.size())
      throw InputError(
          fmt::format("timeseries.csv has no frame {}, which simulation.pvd lists (a "
                      "file was changed or cut short). Run `angio simulate` again",
                      at.frame));
    course.push_back(
        {at.time_s, phase[row], pressure[row], at.frame == shown.peak, shapes.at(at.frame, "")});
    const viewer::Moment &first = course.front().shape, &last = course.back().shape;
    if (last.balloon.vertices.size() != first.balloon.vertices.size() ||
        last.wall.vertices.size() != first.wall.vertices.size() ||
        last.guidewire.size() != first.guidewire.size())
      throw InputError(
          fmt::format("frame {} has other meshes than the first one (a file was "
                      "changed or is damaged). Run `angio simulate` again",
                      at.frame));
  }
  return course;
}

/// The metrics without the times, so that the same input gives the same report.
json repeatable_metrics(const StageWork& work, const ReportSettings& settings,
                        const json& computed) {
  json metrics = collect_metrics(work.files, settings.get<&Config::lesion>(), computed, work.run);
  for (const char* key : {"wall_s", "time_split_s", "frames_per_second", "real_time_factor"})
    metrics["simulation"].erase(key);
  return metrics;
}

/// What the simulation has added: pictures, profiles, curves.
void add_treatment(const StageFiles& files, viewer::ReportContent& content) {
  const json summary = read_json(files.path(file::kSummary));
  content.balloon_chart = {summary.at("chart").at("pressure_atm").get<std::vector<double>>(),
                           summary.at("chart").at("diameter_mm").get<std::vector<double>>()};
  const ShownFrames shown = choose_frames(files, summary);
  const Shapes shapes(files, shown.all());
  content.moments = moments_of(shapes, shown, summary);
  content.sequence = sequence_of(shapes, shown);
  const formats::CsvTable profile = formats::read_csv_table(files.path(file::kProfile));
  content.before = read_profile(profile, "before");
  content.peak = read_profile(profile, "peak");
  content.after = read_profile(profile, "after");
  const formats::CsvTable series = formats::read_csv_table(files.path(file::kTimeSeries));
  content.course = course_of(shapes, shown, series);
  content.time_series = {series.columns, series.rows};
}

viewer::FlowProfile flow_profile(const PullBack& pull) {
  viewer::FlowProfile profile;
  for (const centerline::Estimate& ffr : pull.ffr) {
    profile.ffr.push_back(ffr.value);
    profile.low.push_back(ffr.low);
    profile.high.push_back(ffr.high);
  }
  return profile;
}

/// flow.csv, and its curves for the page.
void add_flow(const StageWork& work, const CaseFlow& flow, viewer::ReportContent& content) {
  if (flow.abscissa_mm.empty()) return;
  content.flow_abscissa_mm = flow.abscissa_mm;
  content.flow_before = flow_profile(flow.before);
  if (flow.after) content.flow_after = flow_profile(*flow.after);
  write_text_atomically(work.out / fs::path(file::kFlow).filename(), flow_csv(flow));
}

/// What the stages have warned of, the treatment's own first.
std::vector<viewer::Doubts> doubts_of(const RunRecord& run, bool is_surface) {
  const std::array<std::pair<Stage, const char*>, 5> groups{
      {{Stage::simulation, "the simulation"},
       {Stage::meshing, "meshes, balloon and wall"},
       {Stage::centerline, "lines and stenoses"},
       {Stage::segmentation, is_surface ? "the surface" : "the image"},
       {Stage::reconstruction, "the X-ray frames"}}};
  std::vector<viewer::Doubts> doubts;
  for (const auto& [stage, about] : groups) {
    doubts.push_back({about, {}});
    const auto record = run.stages.find(stage);
    if (record == run.stages.end()) continue;
    for (const std::string& text : record->second.warnings)
      doubts[concerns_result(stage, text) ? 0 : doubts.size() - 1].texts.push_back(text);
  }
  return doubts;
}

/// What the standard deviation of a throat that was fitted to views does not hold.
void doubt_throat(const json& metrics, std::vector<viewer::Doubts>& doubts) {
  const json& sd = metrics.at("lesion").at("mld_sd_mm");
  if (!sd.is_number()) return;
  doubts.back().texts.push_back(fmt::format(
      "the throat's ± {:.2f} mm is one standard deviation by the pixels' noise alone: it does not "
      "hold what the model leaves out (sections that are not round, what overlaps, a table that "
      "moved, the choice of frames); between runs of a phantom seen from two sides the throat "
      "moved "
      "by up to 0.1 mm",
      sd.get<double>()));
}

}  // namespace

void do_report(StageWork& work, const ReportSettings& settings) {
  const StageFiles& files = work.files;
  const json placement = read_json(files.path(file::kPlacement));
  viewer::ReportContent content;
  content.title = work.run.case_name;
  content.input_kind = work.run.input_kind;
  content.version = kVersion;
  if (!has_surface_input(work.files)) {
    content.volume = segmentation::read_volume_file(files.path(file::kScan));
    content.level_set = read_level_set(work.files);
  }
  content.lumen = read_open_lumen(files);
  if (work.run.input_kind == name(InputKind::run)) content.frames = xray_frames(files);
  content.tree = read_centerlines(files.path(file::kCenterlines));
  content.lesion_path = placement.at("lesion").at("centerline_id").get<int>();
  content.lesion_abscissa_mm = placement.at("lesion").at("abscissa_mm").get<double>();
  if (work.run.is(Stage::simulation, "done")) add_treatment(files, content);
  const CaseFlow flow = case_flow(files, settings.get<&Config::flow>(),
                                  settings.get<&Config::flow_vessel>(), work.run);
  add_flow(work, flow, content);
  const CaseWorkingView view = case_working_view(files, settings.get<&Config::view>(), work.run);
  content.views = carm_views(files, view, content);
  const json metrics =
      repeatable_metrics(work, settings, {{"flow", flow.metrics}, {"working_view", view.metrics}});
  content.metrics_json = metrics.dump();
  content.lesions_json = read_json(files.path(file::kLesions)).dump();
  content.run_json = repeatable_run(work.run).dump();
  content.doubts = doubts_of(work.run, has_surface_input(files));
  doubt_throat(metrics, content.doubts);
  viewer::write_report(work.out, content, work.progress);
}

}  // namespace angio::pipeline
