#include "pipeline/stages/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/stages/frame_writer.hpp"
#include "pipeline/stages/layered_wall.hpp"
#include "pipeline/stages/simulation_input.hpp"
#include "pipeline/stages/treated_lumen.hpp"
#include "pipeline/stages/treatment.hpp"
#include "simulation/balloon_measures.hpp"
#include "simulation/guard.hpp"
#include "simulation/pressed_wall.hpp"
#include "simulation/simulation.hpp"

// From the meshes to what the balloon does.
namespace angio::pipeline {
namespace file = formats::case_file;
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

json finite_or_null(double value) { return std::isfinite(value) ? json(value) : json(); }

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
          {"air_left_out_percent", summary.air_left_out_percent},
          {"mean_sweeps", summary.mean_sweeps}};
}

/// What was reached: metrics.json's lesion, balloon, peak, result and simulation, without the times
/// that differ from run to run. The result is that of the lesion, between its edges; what else lies
/// along the balloon (the next lesion, a neighbour that touches) is the segment's.
json summary_json(json balloon, double reference_mm, const simulation::SimulationSummary& summary,
                  const PeakAndLast& frames) {
  const simulation::SimulationFrame& peak = frames.peak();
  balloon["peak_pressure_atm"] = peak.pressure_atm;
  balloon["peak_diameter_mm"] = peak.balloon_diameter_mm;
  balloon["balloon_to_artery_ratio"] = peak.balloon_diameter_mm / reference_mm;
  return {{"peak_frame", peak.frame},
          {"last_frame", frames.last().frame},
          {"balloon", balloon},
          {"simulation", solver_json(summary)}};
}

/// The balloon at its peak: how far it has lengthened, how far it stays below its chart, and
/// whether it has kinked, which is warned about.
json balloon_json(const simulation::BalloonMaterial& membrane,
                  const simulation::SimulationModel& model, const CenterlinePath& path,
                  const simulation::SimulationFrame& peak, std::vector<std::string>& warnings) {
  const double charted = membrane.chart.empty()
                             ? std::numeric_limits<double>::quiet_NaN()
                             : simulation::chart_diameter_mm(membrane.chart, peak.pressure_atm);
  const simulation::SharpestFold fold =
      simulation::sharpest_fold({peak.balloon, model.balloon.triangles}, model.balloon_fixed);
  const bool is_kinked = fold.angle_degrees > simulation::kKinkDegrees;
  if (is_kinked)
    keep(warnings,
         {fmt::format(
             "the balloon kinks at its peak, {:.1f} mm from the inlet (its membrane folds by "
             "{:.0f} degrees there: the vessel bends too sharply for its length, or it is wider or "
             "under more pressure than fits there). What lies there is not to be trusted: choose a "
             "shorter or smaller balloon (balloon.length_mm, balloon.nominal_diameter_mm), less "
             "pressure or another place",
             project(path, fold.place), fold.angle_degrees)});
  return {{"material", membrane.name},
          {"elongation_mm", finite_or_null(simulation::elongation_mm(model, peak.balloon))},
          {"below_chart_mm", finite_or_null(charted - peak.balloon_diameter_mm)},
          {"dogboning_percent", finite_or_null(simulation::dogboning_percent(peak))},
          {"kinked", is_kinked},
          {"sharpest_fold_degrees", fold.angle_degrees}};
}

/// Where balloon and wall touch at the peak.
json contact_json(const simulation::SimulationModel& model,
                  const simulation::SimulationFrame& peak) {
  const auto pressure = simulation::contact_pressure(model.wall.triangles, peak);
  const simulation::PressedWall pressed = simulation::pressed_wall(model.wall.triangles, peak);
  return {{"contact_gap_mm", simulation::contact_gap_mm(model, peak)},
          {"contact_area_mm2", peak.contact.area_mm2},
          {"contact_pressure_median_kpa", pressure ? json(pressure->median_kpa) : json()},
          {"contact_pressure_p99_kpa", pressure ? json(pressure->p99_kpa) : json()},
          {"contact_force_n", pressed.force_n},
          {"pressed_area_mm2", pressed.area_mm2},
          {"pressed_pressure_median_kpa", finite_or_null(pressed.median_kpa)},
          {"pressed_pressure_p99_kpa", finite_or_null(pressed.p99_kpa)}};
}

void keep_timing(StageWork& work, const simulation::SimulationSummary& summary) {
  work.backend = summary.backend;
  work.device = summary.device;
  work.solver_seconds = summary.wall_s;
  const simulation::TimeSplit& time = summary.time;
  work.time_split = {
      {"solver", time.solver},    {"solver_pairs", time.pairs}, {"solver_balloon", time.balloon},
      {"solver_wall", time.wall}, {"solver_rest", time.rest},   {"air", time.air},
      {"outputs", time.outputs},  {"wire", time.wire},          {"files", time.files},
      {"waiting", time.waiting}};
}

/// The treated path's lumen as the meshing has left it.
TreatedLumen load_treated_lumen(const StageFiles& files, const json& placement, bool is_kept) {
  const json& lesion = placement.at("lesion");
  const CenterlineTree tree = read_centerlines(files.path(file::kCenterlines));
  TriangleMesh lumen = read_open_lumen(files);
  std::vector<int> of_region = read_region_lumen_vertices(files, lumen.vertices.size());
  return {std::move(lumen),
          std::move(of_region),
          path_of(tree, lesion.at("centerline_id").get<int>()),
          treated_spans(placement),
          0.5 * lesion.at("mld_mm").get<double>(),
          is_kept};
}

/// The balloon's chart, for the report: what it measures alone.
json chart_json(const std::vector<simulation::ChartPoint>& chart) {
  json columns = {{"pressure_atm", json::array()}, {"diameter_mm", json::array()}};
  for (const simulation::ChartPoint& point : chart) {
    columns["pressure_atm"].push_back(point.pressure_atm);
    columns["diameter_mm"].push_back(point.diameter_mm);
  }
  return columns;
}

/// The run, and beside it the second one where it is wanted.
struct Runs {
  simulation::SimulationSummary first;
  std::optional<PeakAndLast> second;  ///< unset: there is none
  std::string second_failure;
};

Runs run_both(const simulation::SimulationModel& model,
              const simulation::SimulationOptions& options, bool is_guarded, FrameWriter& frames,
              const Progress& progress) {
  const auto add = [&](const simulation::SimulationFrame& frame) { frames.add(frame); };
  if (!is_guarded) return {simulation::simulate(model, options, add, progress), std::nullopt, ""};
  PeakAndLast second;
  simulation::GuardedSummary both = simulation::simulate_guarded(
      model, options, {}, add,
      [&](const simulation::SimulationFrame& frame) { second.add(share(frame)); }, progress);
  Runs runs{std::move(both.first), std::nullopt, std::move(both.second_failure)};
  if (both.second && runs.second_failure.empty()) runs.second = std::move(second);
  return runs;
}

/// What was simulated, and what came of it.
struct Simulated {
  const simulation::SimulationModel& model;
  const simulation::SimulationOptions& options;
  const TreatedLumen& lumen;
  const Runs& runs;
  const PeakAndLast& frames;
  double most_dogboning_percent;  ///< NaN: it was not watched
};

/// Why a peak tells nothing: too far above the rated burst pressure, where nothing here models the
/// bursting [atm]. How far is a choice of ours, no maker's figure.
std::string burst_reason(double peak_atm, double rated_atm) {
  constexpr double kFarAbove = 1.5;
  if (!(rated_atm > 0.0) || peak_atm <= kFarAbove * rated_atm) return {};
  return fmt::format(
      "{:.1f} atm are {:.1f} times the balloon's rated burst pressure of {:.1f} atm: it may well "
      "burst on the way, which nothing here models. Ask for less (inflation.peak_pressure_atm)",
      peak_atm, peak_atm / rated_atm, rated_atm);
}

/// Of the folder's frames the lumen's profile, the mesh after, and the numbers.
void write_result(StageWork& work, const SimulationSettings& settings, const json& placement,
                  const Simulated& simulated) {
  const auto& [model, options, lumen, runs, frames, most_dogboning] = simulated;
  const simulation::BalloonMaterial& membrane = options.balloon;
  const CenterlineTree tree = read_centerlines(work.files.path(file::kCenterlines));
  const CenterlinePath& path = path_of(tree, placement.at("lesion").at("centerline_id").get<int>());
  const double reference = placement.at("lesion").at("reference_diameter_mm").get<double>();
  const TreatedSpans spans = treated_spans(placement);
  const auto profile = [&](const simulation::SimulationFrame& frame) {
    return simulated.lumen.profile(frame.wall, balloon_in_lumen(frame));
  };
  const auto measures = [&](const std::vector<Vec3>& wall, const centerline::LumenProfile& seen) {
    TreatedMeasures told = simulated.lumen.measures(seen);
    told.lumen_eccentricity = simulated.lumen.eccentricity(wall, told.lesion.mla_abscissa_mm);
    return told;
  };
  const auto before = lumen.profile(model.wall.vertices), peak = profile(frames.peak()),
             after = profile(frames.last());
  const Treatment first{measures(model.wall.vertices, before), measures(frames.peak().wall, peak),
                        measures(frames.last().wall, after)};
  std::optional<Treatment> second;
  if (runs.second)
    second = {first.before, lumen.measures(profile(runs.second->peak())),
              lumen.measures(profile(runs.second->last()))};
  const GuardVerdict guard = settings.get<&Config::guard>()
                                 ? judge(first, second, runs.second_failure)
                                 : GuardVerdict{"off", ""};
  keep(work.warnings, treatment_warnings(first, guard, spans));
  const json& lesion = placement.at("lesion");
  if (placement.at("status") == "done")
    keep(work.warnings,
         start_warnings(first.before, lesion.at("diameter_stenosis_percent"), reference));
  std::vector<Stretch> lesions = lesions_on(path, read_json(work.files.path(file::kLesions)), tree);
  lesions.push_back({lesion.at("proximal_mm").get<double>(), lesion.at("distal_mm").get<double>()});
  const auto widening = widening_beside(before, peak, lesions, reference);
  keep(work.warnings, widening_warnings(widening, placement.at("status") != "no_lesion"));
  write_text_atomically(work.out / "lumen_profile.csv", profile_csv(before, peak, after));
  formats::write_surface(work.out / "lumen_after.vtp", {lumen.mesh(frames.last().wall), {}, {}});
  json reached = summary_json(balloon_json(membrane, model, path, frames.peak(), work.warnings),
                              reference, runs.first, frames);
  reached.update(treatment_json(first, second, reference, frames.peak().balloon_diameter_mm));
  reached["lesion"]["treated_first_mm"] = spans.lesion_first;
  reached["lesion"]["treated_last_mm"] = spans.lesion_last;
  reached["chart"] = chart_json(membrane.chart);
  const double rated = options.inflation.rated_burst_atm;
  reached["balloon"]["rated_burst_atm"] = rated > 0.0 ? json(rated) : json();
  reached["peak"].update(contact_json(model, frames.peak()));
  reached["simulation"]["guard"] = guard.state;
  const std::string burst = burst_reason(frames.peak().pressure_atm, rated);
  reached["guard_reason"] = burst.empty() ? guard.reason : burst;
  reached["balloon"]["widening_beside_lesion"] = widening ? json(widening->ratio) : json();
  reached["balloon"]["dogboning_max_percent"] = finite_or_null(most_dogboning);
  if (frames.last().wall_stress) {
    reached["wall"] = wall_summary(model.layered_wall, frames.peak(), frames.last());
    reached["lesion"]["plaque_eccentricity"] = finite_or_null(
        plaque_eccentricity(model, first.before.lesion.mla_abscissa_mm, 0.25 * reference));
  }
  write_text_atomically(work.out / "summary.json", reached.dump(2) + "\n");
}

/// Frames and time series are kept for diagnosis; not so of a balloon at a healthy place, which
/// nobody has asked for.
void tell_of_failure(StageWork& work, const json& placement,
                     const simulation::SimulationSummary& summary) {
  if (placement.at("status") == "no_lesion") {
    work.is_given_up = true;
    work.warnings = {"the balloon that was tried where no stenosis is certain gives no result: " +
                     summary.failure};
    for (const fs::directory_entry& entry : fs::directory_iterator(work.out))
      fs::remove_all(entry.path());
  } else {
    work.failure = summary.failure;
  }
  write_text_atomically(
      work.out / "diagnosis.json",
      json{{"failure", summary.failure}, {"simulation", solver_json(summary)}}.dump(2) + "\n");
}

}  // namespace

void do_simulation(StageWork& work, const SimulationSettings& settings) {
  const simulation::SimulationOptions& asked = settings.get<&Config::simulation>();
  const json placement = read_json(work.files.path(file::kPlacement));
  const simulation::SimulationModel model = load_simulation_model(work.files, placement);
  const TreatedLumen lumen =
      load_treated_lumen(work.files, placement, settings.get<keeps_triangles>());

  FrameWriter frames(work.out, model, lumen, settings.get<&Config::write_every>());
  const simulation::SimulationOptions options = load_simulation_options(settings, placement);
  const Runs runs = run_both(model, options, settings.get<&Config::guard>(), frames,
                             part(work.progress, 0.0, 0.95));
  frames.finish();
  const simulation::SimulationSummary& summary = runs.first;
  keep_timing(work, summary);
  if (summary.failure.empty())
    write_result(work, settings, placement,
                 {model, options, lumen, runs, frames.kept(), frames.most_dogboning_percent()});
  keep(work.warnings, summary.warnings);  // after what is told of the treatment
  if (settings.get<fold_count>() > 0 && !asked.contact.self_contact)
    keep(work.warnings,
         {"the folds' lobes may pass through each other: contact of the balloon with "
          "itself is not computed (simulation.self_contact)"});
  if (!summary.failure.empty()) tell_of_failure(work, placement, summary);
}

}  // namespace angio::pipeline
