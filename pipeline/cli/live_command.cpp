#include "pipeline/cli/live_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <utility>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/case_status.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/stages/reporter.hpp"
#include "pipeline/stages/run_case.hpp"
#include "pipeline/stages/simulation_input.hpp"
#include "simulation/live.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
namespace {

simulation::LiveSimulation load_live(const LiveArguments& a, double& rated_burst_atm,
                                     simulation::SimulationOptions& options) {
  const CaseFolder folder(a.case_folder);
  refuse_untreated(folder);
  const SimulationSettings settings(case_config(folder));
  const StageFiles files(folder, {file::kCenterlines, file::kPlacement, file::kBalloon,
                                  file::kGuidewire, file::kRegion, file::kAir, file::kLayeredWall});
  const nlohmann::json placement =
      files.exists(file::kPlacement) ? read_json(files.path(file::kPlacement)) : nlohmann::json();
  if (!placement.contains("balloon"))
    throw InputError(fmt::format("{0} has no balloon in its vessel yet (its meshes are missing). "
                                 "Run `angio mesh {0}` first",
                                 a.case_folder.string()),
                     ExitCode::no_input);
  simulation::SimulationModel model = load_simulation_model(files, placement);
  model.air.clear();  // nobody looks at it here
  if (a.wall == "shape_matching") model.layered_wall = {};
  options = load_simulation_options(settings, placement);
  rated_burst_atm = options.inflation.rated_burst_atm;
  return {std::move(model), options};
}

/// The frame that the simulation has come to.
viewer::LiveState shown(const simulation::LiveSimulation& live) {
  const simulation::SimulationFrame& frame = live.frame();
  viewer::LiveState state;
  state.shape.balloon = {frame.balloon, live.model().balloon.triangles};
  state.shape.wall = {frame.wall, live.model().wall.triangles};
  state.shape.contact_pressure_kpa = frame.contact_pressure_kpa;
  state.shape.guidewire = frame.guidewire;
  state.time_s = frame.time_s;
  state.pressure_atm = frame.pressure_atm;
  state.volume_mm3 = frame.balloon_volume_mm3;
  state.diameter_mm = frame.balloon_diameter_mm;
  state.place_mm = live.place_mm();
  state.is_stuck = live.is_stuck();
  return state;
}

}  // namespace

CLI::App& add_live_command(CLI::App& app, LiveArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "live",
      "the simulation of a meshed case in a window, driven by hand: sliders or keys\n"
      "inflate, let down and move the balloon along the vessel. Nothing is written to CASE");
  command.add_option("CASE", a.case_folder, "the case's folder")->required();
  command
      .add_option("--wall", a.wall,
                  "case: as the case has it; shape_matching: the quick wall, for an answer at hand")
      ->check(CLI::IsMember({"case", "shape_matching"}))
      ->capture_default_str();
  command
      .add_option("--pressure", a.options.pressure_atm,
                  "what is asked for at the start [atm], up to the case's peak")
      ->check(CLI::Range(0.0, 40.0))
      ->type_name("ATM")
      ->capture_default_str();
  command
      .add_option("--seconds", a.options.seconds,
                  "close after so long, for measuring; 0: when you close it")
      ->check(CLI::Range(0.0, 86400.0))
      ->type_name("S")
      ->capture_default_str();
  command
      .add_option("--keys", a.options.keys,
                  "keys pressed at the start, by X's names: --keys Up,Up,Right")
      ->delimiter(',');
  command
      .add_option("--screenshot", a.options.screenshot,
                  "the last picture, as PNG; without --seconds the first, and it ends")
      ->type_name("FILE");
  add_output_options(command, a.shared);
  return command;
}

int do_live(const LiveArguments& a) {
  end_in_own_time();  // its window closes on Ctrl-C
  Reporter reporter(a.shared.style());
  viewer::LiveDrive drive;
  simulation::SimulationOptions options;
  simulation::LiveSimulation live = load_live(a, drive.rated_burst_atm, options);
  drive.frame_s = options.frame_s;
  drive.most_pressure_atm = options.inflation.peak_pressure_atm;
  if (a.options.pressure_atm > drive.most_pressure_atm)
    reporter.note(fmt::format(
        "--pressure asks for {:.2f} atm, but the case's peak is {:.2f} atm: it begins at that "
        "(inflation.peak_pressure_atm)",
        a.options.pressure_atm, drive.most_pressure_atm));
  drive.least_place_mm = live.least_place_mm();
  drive.most_place_mm = live.most_place_mm();
  drive.first = shown(live);
  drive.step = [&](const viewer::LiveAim& aim) {
    live.step({aim.pressure_atm, aim.place_mm});
    return shown(live);
  };
  const viewer::LiveRates rates = viewer::show_live(a.case_folder, drive, a.options);
  reporter.result(
      fmt::format("{:.1f} solver frames/s ({:.0f} % of the time at work), {:.1f} pictures/s in "
                  "{:.1f} s; balloon "
                  "{:.2f} mm3 at the start, {:.2f} mm3 at the end, {:.2f} atm, moved by {:.2f} mm",
                  rates.frames_per_second(), 100.0 * rates.busy_s / rates.seconds,
                  rates.pictures_per_second(), rates.seconds, drive.first.volume_mm3,
                  rates.last.volume_mm3, rates.last.pressure_atm, rates.last.place_mm));
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
