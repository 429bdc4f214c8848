#include "pipeline/stages/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include "centerline/centerline.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "meshing/subdivide.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/config/shared_quantities.hpp"
#include "pipeline/stages/layered_wall.hpp"
#include "simulation/balloon_measures.hpp"
#include "simulation/simulation.hpp"

// From the meshes to what the balloon does.
namespace angio::pipeline {
namespace file = formats::case_file;
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

Vec3 vec3_of(const json& node) {
  return {node.at(0).get<double>(), node.at(1).get<double>(), node.at(2).get<double>()};
}

/// Writes frames as they come: every n-th, and in the end the peak and the last.
class FrameWriter {
 public:
  FrameWriter(fs::path folder, const simulation::SimulationModel& model, int write_every)
      : folder_(std::move(folder)), model_(model), write_every_(write_every) {}

  void add(const simulation::SimulationFrame& frame) {
    rows_ += time_series_row(frame) + "\n";
    if (frame.frame % write_every_ == 0) write(frame);
    if (peak_.balloon.empty() || frame.pressure_atm >= peak_.pressure_atm) peak_ = frame;
    last_ = frame;
  }

  void finish() {
    write(peak_);
    write(last_);
    std::sort(steps_.begin(), steps_.end(), [](const auto& a, const auto& b) {
      return std::tie(a.time_s, a.part) < std::tie(b.time_s, b.part);
    });
    formats::write_collection(folder_ / "simulation.pvd", steps_);
    write_text_atomically(folder_ / "timeseries.csv",
                          std::string(kTimeSeriesHeader) + "\n" + rows_);
  }

  [[nodiscard]] const simulation::SimulationFrame& peak() const { return peak_; }
  [[nodiscard]] const simulation::SimulationFrame& last() const { return last_; }

 private:
  void write(const simulation::SimulationFrame& frame) {
    if (!written_.insert(frame.frame).second) return;
    write_frame(folder_ / "frames", model_, frame);
    steps_.push_back({frame.time_s, 0, fmt::format("frames/balloon_{:06d}.vtp", frame.frame)});
    steps_.push_back({frame.time_s, 1, fmt::format("frames/vessel_{:06d}.vtp", frame.frame)});
    if (!frame.guidewire.empty())
      steps_.push_back({frame.time_s, 3, fmt::format("frames/guidewire_{:06d}.vtp", frame.frame)});
    if (frame.layered_wall.empty()) return;
    steps_.push_back({frame.time_s, 2, fmt::format("frames/wall_{:06d}.vtu", frame.frame)});
    write_wall_frame(folder_ / steps_.back().file, model_.layered_wall, frame);
  }

  fs::path folder_;
  const simulation::SimulationModel& model_;
  int write_every_;
  std::string rows_;
  std::set<int> written_;
  std::vector<formats::TimeStep> steps_;
  simulation::SimulationFrame peak_;
  simulation::SimulationFrame last_;
};

/// The whole lumen with the region moved to where a frame has it.
TriangleMesh moved_lumen(TriangleMesh lumen, const std::vector<int>& lumen_vertices,
                         const std::vector<Vec3>& wall) {
  for (std::size_t v = 0; v < wall.size(); ++v)
    lumen.vertices[std::size_t(lumen_vertices[v])] = wall[v];
  return lumen;
}

/// The places that both profiles have: near a rim a section may be had before or after only.
std::string profile_csv(const centerline::LumenProfile& before,
                        const centerline::LumenProfile& after) {
  std::string text =
      "abscissa_mm,inscribed_diameter_before_mm,equivalent_diameter_before_mm,"
      "inscribed_diameter_after_mm,equivalent_diameter_after_mm\n";
  const auto equivalent = [](double area) { return 2.0 * std::sqrt(area / units::kPi); };
  std::size_t j = 0;
  for (std::size_t i = 0; i < before.abscissa.size(); ++i) {
    while (j < after.abscissa.size() && after.abscissa[j] < before.abscissa[i]) ++j;
    if (j == after.abscissa.size() || after.abscissa[j] != before.abscissa[i]) continue;
    text += fmt::format("{:.4f},{:.5f},{:.5f},{:.5f},{:.5f}\n", before.abscissa[i],
                        2.0 * before.inscribed_radius[i], equivalent(before.section_area[i]),
                        2.0 * after.inscribed_radius[j], equivalent(after.section_area[j]));
  }
  return text;
}

/// How the solver fared: metrics.json's simulation, without the times that differ from run to run.
json solver_json(const simulation::SimulationSummary& summary) {
  return {{"backend", summary.backend},
          {"device", summary.device},
          {"frame_count", summary.frame_count},
          {"simulated_s", summary.simulated_s},
          {"max_penetration_mm", summary.max_penetration_mm},
          {"worst_contact_pressure_ratio", summary.worst_pressure_ratio},
          {"worst_residual", summary.worst_residual},
          {"inverted_air_tets", summary.inverted_air_tets},
          {"air_flips", summary.flip_count},
          {"air_rebuilds", summary.air_rebuild_count},
          {"frames_without_air", summary.frames_without_air},
          {"mean_sweeps", summary.mean_sweeps}};
}

/// What was reached: metrics.json's balloon, result and simulation, without the times that differ
/// from run to run. The result is that of the lesion, between its edges; what else lies along the
/// balloon (the next lesion, a neighbour that touches) is the segment's.
json summary_json(const json& balloon, const json& lesion,
                  const simulation::SimulationSummary& summary, const FrameWriter& frames,
                  const centerline::LumenProfile& after) {
  const double reference = lesion.at("reference_diameter_mm").get<double>();
  const auto [mld, mla] = centerline::tightest_between(
      after, lesion.at("proximal_mm").get<double>(), lesion.at("distal_mm").get<double>());
  const centerline::Tightest segment = centerline::tightest_between(after, -1e9, 1e9);
  const double peak_diameter = frames.peak().balloon_diameter_mm;
  json reached = balloon;
  reached["peak_pressure_atm"] = frames.peak().pressure_atm;
  reached["peak_diameter_mm"] = peak_diameter;
  reached["balloon_to_artery_ratio"] = peak_diameter / reference;
  return {{"peak_frame", frames.peak().frame},
          {"last_frame", frames.last().frame},
          {"balloon", reached},
          {"result",
           {{"mld_mm", mld},
            {"mla_mm2", mla},
            {"diameter_stenosis_percent", 100.0 * (1.0 - mld / reference)},
            {"acute_gain_mm", mld - lesion.at("mld_mm").get<double>()},
            {"recoil_mm", peak_diameter - mld},
            {"recoil_percent", 100.0 * (peak_diameter - mld) / peak_diameter},
            {"segment_mld_mm", segment.mld_mm},
            {"segment_mla_mm2", segment.mla_mm2}}},
          {"simulation", solver_json(summary)}};
}

/// The solver's model from the files of the stages before.
simulation::SimulationModel load_model(const StageFiles& files, const json& placement) {
  const json& lesion = placement.at("lesion");
  simulation::SimulationModel model = read_simulation_model(files);
  model.reference_radius_mm = 0.5 * lesion.at("reference_diameter_mm").get<double>();
  model.measure_point = vec3_of(placement.at("site").at("point"));
  model.measure_tangent = vec3_of(placement.at("site").at("tangent"));
  model.watch_first_mm = lesion.at("proximal_mm").get<double>();
  model.watch_last_mm = lesion.at("distal_mm").get<double>();
  model.layered_wall = read_layered_wall(files, model.wall);
  return model;
}

/// The balloon at its peak: how far it has lengthened, how far it stays below its chart, and
/// whether it has kinked, which is warned about.
json balloon_json(const simulation::BalloonMaterial& membrane,
                  const simulation::SimulationModel& model, const CenterlinePath& path,
                  const simulation::SimulationFrame& peak, std::vector<std::string>& warnings) {
  const auto or_null = [](bool is_known, double value) { return is_known ? json(value) : json(); };
  const double charted = membrane.chart.empty()
                             ? std::numeric_limits<double>::quiet_NaN()
                             : simulation::chart_diameter_mm(membrane.chart, peak.pressure_atm);
  const simulation::SharpestFold fold =
      simulation::sharpest_fold({peak.balloon, model.balloon.triangles}, model.balloon_fixed);
  const bool is_kinked = fold.angle_degrees > simulation::kKinkDegrees;
  if (is_kinked)
    keep(warnings,
         {fmt::format("the balloon kinks at its peak, {:.1f} mm from the inlet (its skin folds by "
                      "{:.0f} degrees there; the vessel bends too sharply for its length). What "
                      "lies there is not to be trusted: choose a shorter balloon "
                      "(balloon.length_mm) or another place",
                      project(path, fold.place), fold.angle_degrees)});
  return {{"material", membrane.name},
          {"elongation_mm",
           or_null(!model.balloon_sliding.empty(), simulation::elongation_mm(model, peak.balloon))},
          {"below_chart_mm", or_null(std::isfinite(charted), charted - peak.balloon_diameter_mm)},
          {"kinked", is_kinked},
          {"sharpest_fold_degrees", fold.angle_degrees}};
}

void keep_timing(StageWork& work, const simulation::SimulationSummary& summary) {
  work.backend = summary.backend;
  work.device = summary.device;
  work.solver_seconds = summary.wall_s;
  const simulation::TimeSplit& time = summary.time;
  work.time_split = {{"solver", time.solver},
                     {"air", time.air},
                     {"outputs", time.outputs},
                     {"files", time.files},
                     {"waiting", time.waiting}};
}

}  // namespace

void do_simulation(StageWork& work, const SimulationSettings& settings) {
  const simulation::SimulationOptions& asked = settings.get<&Config::simulation>();
  const json placement = read_json(work.files.path(file::kPlacement));
  const json& lesion = placement.at("lesion");
  const json& site = placement.at("site");
  const simulation::SimulationModel model = load_model(work.files, placement);

  FrameWriter frames(work.out, model, settings.get<&Config::write_every>());
  const simulation::SimulationOptions options =
      solver_options(asked, settings.get<&Config::plaque>(), settings.get<shaft_diameter>(),
                     placement.at("balloon").at("nominal_diameter_mm").get<double>(),
                     is_usual_balloon(asked.balloon, settings.get<rest_diameter>()));
  const simulation::SimulationSummary summary = simulation::simulate(
      model, options, [&](const simulation::SimulationFrame& frame) { frames.add(frame); },
      part(work.progress, 0.0, 0.95));
  frames.finish();
  keep(work.warnings, summary.warnings);
  if (settings.get<fold_count>() > 0 && !asked.contact.self_contact)
    keep(work.warnings,
         {"the folds' lobes may pass through each other: contact of the balloon with "
          "itself is not computed (simulation.self_contact)"});
  keep_timing(work, summary);
  if (!summary.failure.empty()) {
    work.failure = summary.failure;
    write_text_atomically(
        work.out / "diagnosis.json",
        json{{"failure", summary.failure}, {"simulation", solver_json(summary)}}.dump(2) + "\n");
    return;
  }

  const CenterlineTree tree = read_centerlines(work.files.path(file::kCenterlines));
  const CenterlinePath& path = path_of(tree, lesion.at("centerline_id").get<int>());
  const TriangleMesh lumen = read_open_lumen(work.files);
  const TriangleMesh lumen_after =
      moved_lumen(lumen, read_region_lumen_vertices(work.files), frames.last().wall);
  // The lesion and, beside it, what the balloon reaches.
  const double first = std::min(site.at("balloon_first_abscissa_mm").get<double>(),
                                lesion.at("proximal_mm").get<double>());
  const double last = std::max(site.at("balloon_last_abscissa_mm").get<double>(),
                               lesion.at("distal_mm").get<double>());
  const double radius = 0.5 * lesion.at("mld_mm").get<double>();
  const bool keep_mesh = settings.get<keeps_triangles>();
  const auto measure = [&](const TriangleMesh& mesh) {
    return centerline::measure_lumen(keep_mesh ? meshing::fine_enough(mesh, radius) : mesh, path,
                                     first, last);
  };
  const auto before = measure(lumen);
  const auto after = measure(lumen_after);
  write_text_atomically(work.out / "lumen_profile.csv", profile_csv(before, after));
  formats::write_surface(work.out / "lumen_after.vtp", {lumen_after, {}, {}});
  json reached =
      summary_json(balloon_json(options.balloon, model, path, frames.peak(), work.warnings), lesion,
                   summary, frames, after);
  if (!frames.last().wall_stress.empty())
    reached["wall"] = wall_summary(model.layered_wall, frames.peak(), frames.last());
  write_text_atomically(work.out / "summary.json", reached.dump(2) + "\n");
}

}  // namespace angio::pipeline
