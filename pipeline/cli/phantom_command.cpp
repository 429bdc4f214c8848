#include "pipeline/cli/phantom_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <sstream>
#include <vector>

#include "core/error.hpp"

namespace angio::pipeline {
namespace {

void add_run_options(CLI::App& command, PhantomArguments& arguments) {
  datasets::RotationalRunOptions& run = arguments.run;
  constexpr const char* kGroup = "Of an xa-run or xa-views";
  const auto add = [&](const char* option, auto& field, const char* help) {
    command.add_option(option, field, help)->capture_default_str()->group(kGroup);
  };
  command
      .add_option("--frames", run.frames, "how many, 3 to 2000; of each of xa-views 8 by default")
      ->each([&arguments](const std::string&) { arguments.frames_are_given = true; })
      ->capture_default_str()
      ->group(kGroup);
  add("--views", arguments.views,
      "of xa-views: where the C-arm stands, primary/secondary angles [degrees]");
  add("--arc", run.arc_degrees, "from the first to the last [degrees], 1 to 400");
  add("--contrast", run.contrast_per_mm, "attenuation of the medium above blood's [1/mm], to 1");
  add("--wobble", run.wobble_mm,
      "shift of the C-arm that its header does not tell, sd [mm], 0 to 5; of xa-views one of\n"
      "each view");
  add("--wobble-angle", run.wobble_degrees, "the same for its turn [degrees], 0 to 5");
  add("--frame-time", run.frame_time_ms, "from a frame to the next [ms], 1 to 10000");
  add("--heartbeat", run.heartbeat_mm,
      "the longest way of a place of the wall with each beat [mm], 0 to 20");
  add("--heart-rate", run.heart_rate_per_min, "beats a minute, 30 to 200");
  add("--breathing", run.breathing_mm, "way of all vessels with each breath [mm], 0 to 30");
  add("--breaths", run.breaths_per_min, "breaths a minute, 4 to 60");
  add("--inflow", run.inflow_s, "until the contrast medium has filled the vessels [s], 0 to 30");
  command
      .add_flag_callback(
          "--no-r-waves", [&run] { run.tells_r_waves = false; },
          "the header does not name the heart's R waves")
      ->group(kGroup);
  command.add_flag("--mask-run", run.mask_run, "the same turn without contrast medium, too")
      ->group(kGroup);
  command
      .add_flag_callback(
          "--no-body", [&run] { run.body = false; }, "without tissue and bone around the vessels")
      ->group(kGroup);
}

/// "-30/20,40/-15".
std::vector<angiogram::CArmAngles> views_of(const std::string& text) {
  std::vector<angiogram::CArmAngles> views;
  std::istringstream in(text);
  char slash = 0, comma = ',';
  for (angiogram::CArmAngles view; comma == ',';) {
    if (!(in >> view.primary_degrees >> slash >> view.secondary_degrees) || slash != '/')
      throw Error(ExitCode::usage,
                  fmt::format("--views {}: must be primary/secondary angles in degrees, parted by "
                              "commas, as -30/20,40/-15",
                              text));
    views.push_back(view);
    if (!(in >> comma)) comma = 0;
  }
  return views;
}

int do_xa_run(const PhantomArguments& arguments) {
  datasets::RotationalRunOptions run = arguments.run;
  const datasets::PhantomOptions& options = arguments.options;
  if (arguments.noise_is_given) run.noise = options.noise_sd;
  if (arguments.format == "xa-views") {
    constexpr int kFramesOfView = 8;
    run.views = views_of(arguments.views);
    if (!arguments.frames_are_given) run.frames = kFramesOfView;
  }
  try {
    run.validate();
  } catch (const OptionError& error) {
    throw Error(ExitCode::usage, error.what());
  }
  const auto made = datasets::make_rotational_run(options, run);
  fmt::print("{}\n", datasets::write_rotational_run(made, options, arguments.folder).string());
  return int(ExitCode::done);
}

}  // namespace

void add_phantom_command(CLI::App& app, PhantomArguments& phantom) {
  CLI::App& command = *app.add_subcommand(
      "phantom",
      "a phantom with its truth\n"
      "NAME: straight, concentric, unilateral, bilateral, tandem, helix, torus,\n"
      "ytype, trifurcation, aneurysm, coronary or cloth");
  auto& o = phantom.options;
  command.add_option("NAME", o.name, "which phantom")->required();
  command.add_option("-o,--output", phantom.folder, "folder to write into")->required();
  command
      .add_option(
          "--format", phantom.format,
          "dicom (CT series), xray3d (X-Ray 3D Angiographic DICOM), xa-run (the X-ray\n"
          "frames of a rotational run, DICOM), xa-views (those of a C-arm that stands still at\n"
          "some places), nrrd or surface")
      ->check(CLI::IsMember({"dicom", "xray3d", "xa-run", "xa-views", "nrrd", "surface"}))
      ->capture_default_str();
  command.add_option("--stenosis", o.stenosis_percent, "diameter stenosis [%], 0 to 95")
      ->capture_default_str();
  command.add_option("--radius", o.radius_mm, "at the inlet [mm], 0.4 to 15; 0: the phantom's own")
      ->capture_default_str();
  command
      .add_option("--length", o.length_mm,
                  "of the main branch [mm], 5 to 200; 0: the phantom's own")
      ->capture_default_str();
  command.add_option("--spacing", o.spacing_mm, "voxel size [mm], 0.05 to 2")
      ->capture_default_str();
  command.add_option("--slice", o.slice_mm, "distance of slices, if it is another [mm], 0.05 to 5")
      ->capture_default_str();
  command
      .add_option("--noise", o.noise_sd,
                  "standard deviation as a fraction of the contrast, 0 to 1; of an xa-run: of\n"
                  "a pixel behind the body, 0 to 0.5, by default 0.02")
      ->each([&phantom](const std::string&) { phantom.noise_is_given = true; })
      ->capture_default_str();
  command
      .add_option("--blur", o.blur_mm,
                  "standard deviation of the scanner's blur [mm], 0 to 3; 0: 0.6 voxels\n"
                  "along each axis")
      ->capture_default_str();
  command
      .add_option("--oblique", o.oblique_degrees,
                  "turn of the voxel grid around (1, 2, 3) [degrees], 0 to 90")
      ->capture_default_str();
  command.add_option("--seed", o.seed, "of the noise")->capture_default_str();
  add_run_options(command, phantom);
}

int do_phantom(const PhantomArguments& arguments) {
  using datasets::PhantomFormat;
  const PhantomFormat format = arguments.format == "nrrd"      ? PhantomFormat::nrrd
                               : arguments.format == "xray3d"  ? PhantomFormat::xray_3d
                               : arguments.format == "surface" ? PhantomFormat::surface
                                                               : PhantomFormat::dicom;
  try {
    arguments.options.validate();
  } catch (const OptionError& error) {  // on the command line, not in a configuration
    throw Error(ExitCode::usage, error.what());
  }
  const bool is_xa = arguments.format == "xa-run" || arguments.format == "xa-views";
  if (is_xa && arguments.options.slice_mm > 0.0)
    throw Error(ExitCode::usage,
                "--slice is that of a scan (an xa-run has no slices). Leave it out");
  if (is_xa) return do_xa_run(arguments);
  const datasets::Phantom phantom = format == PhantomFormat::surface
                                        ? datasets::make_phantom_surface(arguments.options)
                                        : datasets::make_phantom(arguments.options);
  const std::filesystem::path written =
      datasets::write_phantom(phantom, arguments.options, format, arguments.folder);
  fmt::print("{}\n", written.string());
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
