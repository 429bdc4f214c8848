#include "pipeline/cli/run_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "dicom/archive.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/fetched_scan.hpp"
#include "pipeline/case/hidden_input.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/case/read_out.hpp"
#include "pipeline/cli/archive_commands.hpp"
#include "pipeline/cli/stage_commands.hpp"
#include "pipeline/experiments/paper_input.hpp"
#include "pipeline/experiments/workflow.hpp"
#include "pipeline/stages/require_backend.hpp"

namespace angio::pipeline {
namespace {

constexpr std::string_view kPaperPrefix = "paper-";  // of the experiments' presets

/// Puts options under a heading of --help; the others stand under the first, "Options".
void group_options(CLI::App& command, const char* heading,
                   std::initializer_list<const char*> names) {
  for (const char* option : names) command.get_option(option)->group(heading);
}

/// What `run` and `experiment` share.
void add_case_options(CLI::App& command, RunArguments& run) {
  command.add_option("-o,--output", run.request.case_folder, "the case's folder")
      ->type_name("CASE");
  command.add_option("--name", run.request.case_name,
                     "the case's name in the report; otherwise a hash of the input");
  command.add_option("--from", run.from, "run this stage and those after it again")
      ->type_name("STAGE");
  command
      .add_option(
          "--until", run.until,
          "last stage: reconstruction, segmentation, centerline, meshing, simulation or report")
      ->type_name("STAGE");
  add_read_options(command, run.read);
  add_unit_option(command, run.unit);
  command
      .add_option(
          "--geometry", run.request.geometry,
          "where X-ray frames were taken, instead of what their header says: RTK's XML, or\n"
          "CSV of 3 x 4 matrices; INPUT may then be a stack of frames (.mha .nrrd .tif ...)")
      ->type_name("FILE");
  command
      .add_option(
          "--inlet", run.inlet,
          "where blood comes in: a point in LPS [mm], or of a surface the number of an open\n"
          "end as `angio inspect` lists them; otherwise by the tree's shape")
      ->type_name("X,Y,Z|END");
  add_calling_option(command, run.calling);
  command.add_flag("--force", run.request.force, "run everything again, into any folder");
  command.add_flag(
      "--keep-link", run.request.keep_link,
      "keep the input's path in source.private.json and, of a DICOM scan, the lumen as\n"
      "DICOM SEG in segmentation.private.dcm (mode 0600)");
  command.add_flag(
      "--hide-input", run.hide_input,
      "name no path or file of the input in messages: what is printed goes into a log");
  add_keep_option(command, run.keep);
  command.add_flag("--print-config", run.print_config, "print every option in force and end");
  add_run_options(command, run.shared, PresetHelp::full);
  group_options(command, "Input",
                {"--series", "--views", "--ends", "--allow-lossy", "--spacing", "--resample",
                 "--angles", "--max-memory", "--unit", "--inlet", "--geometry", "--calling"});
  group_options(command, "Treatment",
                {"--balloon", "--catalogue", "--contact", "--preset", "--set", "--config"});
  group_options(command, "Output",
                {"--output", "--name", "--keep-link", "--hide-input", "--keep", "--quiet", "--json",
                 "--print-config"});
}

}  // namespace

void add_run_command(CLI::App& app, RunArguments& run) {
  CLI::App& command = *app.add_subcommand(
      "run",
      "every stage, from the input to the report\n"
      "INPUT: a DICOM folder or file, a volume (.nrrd .nhdr .mha .mhd .nii .nii.gz .vti .vtk "
      ".tif), a\n"
      "lumen surface or mesh (.stl .vtp .vtk .vtu .ply .obj .off .msh .mesh .glb .gltf), or\n"
      "phantom:NAME[,key=value...]; none with a preset of the seed paper's experiments\n"
      "(paper-...); or pacs://AET@HOST:PORT/STUDY_UID[/SERIES_UID]");
  command.add_option("INPUT", run.request.input,
                     "scan, surface or phantom; none: CASE goes on from its own files and options");
  add_case_options(command, run);
}

void add_experiment_command(CLI::App& app, ExperimentArguments& experiment) {
  std::vector<std::string> names;
  for (const std::string& preset : preset_names())
    if (preset.starts_with(kPaperPrefix)) names.push_back(preset.substr(kPaperPrefix.size()));
  CLI::App& command = *app.add_subcommand(
      "experiment",
      "an experiment of the seed paper: `angio run` with the preset paper-NAME\n"
      "NAME: " +
          fmt::format("{}", fmt::join(names, ", ")) +
          "\nINPUT: your own vessel, for the coronaries");
  command.add_option("NAME", experiment.name, "which experiment")
      ->required()
      ->check(CLI::IsMember(names));
  command.add_option("INPUT", experiment.run.request.input, "scan or surface, for the coronaries");
  add_case_options(command, experiment.run);
}

/// A case that was run before goes on from its own files and options where no INPUT is named.
bool goes_on(const RunArguments& run) {
  return run.request.input.empty() && run.shared.presets.empty() &&
         !run.request.case_folder.empty() && CaseFolder(run.request.case_folder).exists("run.json");
}

namespace {

/// Fetches an INPUT that an archive holds; the run then goes on from the files.
std::optional<FetchedScan> fetch_input(RunArguments& run, Reporter& reporter) {
  if (!dicom::is_archive_location(run.request.input)) return std::nullopt;
  if (run.request.until >= Stage::simulation)
    require_backend(run.request.config.simulation.backend);
  reporter.begin_stage("fetch");
  std::optional<FetchedScan> fetched(std::in_place, run.request.input, run.calling,
                                     reporter.progress());
  run.request.source = std::exchange(run.request.input, fetched->path());
  return fetched;
}

void apply_inlet(Config& config, const std::string& inlet) {
  const bool is_point = inlet.find(',') != std::string::npos;
  apply_option(
      config, "--inlet", inlet,
      is_point ? "centerline.inlet_lps_mm=[" + inlet + "]" : "centerline.inlet_end=" + inlet,
      "a point X,Y,Z in LPS [mm], or the number of an open end of a surface");
}

[[noreturn]] void refuse_without_input(const RunArguments& run) {
  const std::filesystem::path& folder = run.request.case_folder;
  if (!run.shared.settings.empty())  // which may have swallowed it
    throw Error(ExitCode::usage,
                "`angio run` needs an INPUT, before any --set. See `angio run --help`");
  throw Error(ExitCode::usage,
              "`angio run` needs an INPUT" +
                  (folder.empty() ? std::string()
                                  : ": " + folder.string() +
                                        " is no case yet, from whose files it could go on") +
                  ". Give one, as `angio run INPUT -o CASE`; see `angio run --help`");
}

int run_whole(RunArguments& run) {
  const bool is_known = goes_on(run);
  if (is_known) run.request.config = case_config(CaseFolder(run.request.case_folder));
  const Config former = run.request.config;
  apply_options(run.request.config, run.shared);
  apply_read_options(run.request.config, run.read);
  if (!run.unit.empty()) apply_setting(run.request.config, "input.unit=" + run.unit);
  if (!run.inlet.empty()) apply_inlet(run.request.config, run.inlet);
  if (run.print_config) {
    fmt::print("{}", to_toml(run.request.config));
    return int(ExitCode::done);
  }
  if (run.request.input.empty()) run.request.input = default_input(run.request.config);
  if (is_known && run.request.input.empty()) refuse_other_input(former, run.request.config, "run");
  if (run.request.input.empty() && !is_known) refuse_without_input(run);
  if (run.request.case_folder.empty())
    throw Error(ExitCode::usage,
                "`angio run` needs a folder for the case: add -o CASE. See `angio run --help`");
  check_experiment_input(run.request.config, run.request.input);
  if (!run.from.empty()) run.request.from = stage_of("--from", run.from);
  if (!run.until.empty()) run.request.until = stage_of("--until", run.until);
  if (run.request.from && *run.request.from > run.request.until)
    throw Error(ExitCode::usage, "--from names a stage after --until");
  run.request.keep = keep_of(run.keep);
  if (run.request.keep == Keep::minimal && run.request.until != Stage::report)
    throw Error(ExitCode::usage,
                "--keep minimal is for a whole run (the stages after --until would have nothing to "
                "go on from). Leave one of them out");
  Reporter reporter(run.shared.style());
  const std::optional<FetchedScan> fetched = fetch_input(run, reporter);
  const std::filesystem::path result =
      run_case(workflow_of(run.request.config), run.request, reporter);
  const CaseFolder folder(run.request.case_folder);
  for (const std::string& line :
       read_out(read_json(folder.path(formats::case_file::kMetrics)), folder.read_record()))
    reporter.note(line);
  reporter.result(result.string());
  return int(ExitCode::done);
}

}  // namespace

int do_run(RunArguments& run) {
  try {
    return run_whole(run);
  } catch (const Error& error) {
    if (!run.hide_input) throw;
    throw Error(error.exit_code(), without_input(error.what(), run.request.input));
  }
}

int do_experiment(ExperimentArguments& experiment) {
  auto& presets = experiment.run.shared.presets;
  presets.insert(presets.begin(), std::string(kPaperPrefix) + experiment.name);
  return do_run(experiment.run);
}

}  // namespace angio::pipeline
