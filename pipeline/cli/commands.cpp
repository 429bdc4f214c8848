#include "pipeline/cli/commands.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>
#include <new>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/text.hpp"
#include "pipeline/cli/batch.hpp"
#include "pipeline/cli/command_description.hpp"
#include "pipeline/cli/data_commands.hpp"
#include "pipeline/cli/doctor.hpp"
#include "pipeline/cli/inflate_command.hpp"
#include "pipeline/cli/reporter.hpp"
#include "pipeline/config/balloon_file.hpp"
#include "pipeline/config/config.hpp"
#include "pipeline/experiments/experiment.hpp"
#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_table.hpp"
#include "pipeline/stages/stage_work.hpp"
#include "pipeline/stages/stages.hpp"
#include "pipeline/version.hpp"
#include "viewer/view.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

/// Options that several commands share, as they stand on the command line.
struct SharedOptions {
  std::string config_file;
  std::vector<std::string> presets;
  std::vector<std::string> settings;
  std::string balloon, catalogue;
  std::string contact;
  std::string backend = "auto";
  int threads = 0;
  bool quiet = false;
  bool json = false;

  [[nodiscard]] ReportStyle style() const {
    return json ? ReportStyle::json : (quiet ? ReportStyle::quiet : ReportStyle::automatic);
  }
};

void add_output_options(CLI::App& command, SharedOptions& shared) {
  command.add_flag("--quiet", shared.quiet, "no progress; warnings and errors only");
  command.add_flag("--json", shared.json, "results and events as JSON on standard output");
}

void add_run_options(CLI::App& command, SharedOptions& shared) {
  add_output_options(command, shared);
  command.add_option("--config", shared.config_file, "options from a TOML file (a case.toml)")
      ->type_name("FILE");
  command.add_option("--set", shared.settings, "one option or more; --print-config lists them all")
      ->type_name("SECTION.KEY=VALUE")
      ->expected(1, -1);
  command.add_option("--preset", shared.presets,
                     preset_help())
      ->type_name("NAME")
      ->allow_extra_args(false);  // else it takes INPUT for a second one
  command
      .add_option("--balloon", shared.balloon,
                  "a balloon of the catalogue (`angio inflate --list`): its size, skin, chart and "
                  "nominal pressure")
      ->type_name("NAME");
  command
      .add_option("--catalogue", shared.catalogue, "balloons of your own, TOML as balloons.toml")
      ->type_name("FILE");
  command
      .add_option("--contact", shared.contact,
                  "how balloon and wall touch: barrier (default), or paper (for comparison)")
      ->check(CLI::IsMember({"barrier", "paper"}));
  command.add_option("--backend", shared.backend, "where the simulation runs: auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  command
      .add_option("--threads", shared.threads, "CPU threads, 1 to 1024; 0: as many as there are")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

/// Files first, then presets, the balloon, and single settings, so that the more special wins.
void apply_options(Config& config, const SharedOptions& shared) {
  if (!shared.config_file.empty()) {
    if (!fs::exists(shared.config_file))
      throw InputError(
          fmt::format("there is no {} (no such configuration file)", shared.config_file),
          ExitCode::no_input);
    load_config(config, shared.config_file);
  }
  for (const std::string& preset : shared.presets) apply_preset(config, preset);
  if (!shared.balloon.empty())
    apply_balloon(config, find_balloon(balloon_catalogue(shared.catalogue), shared.balloon));
  if (!shared.contact.empty()) apply_setting(config, "simulation.contact_model=" + shared.contact);
  for (const std::string& setting : shared.settings) apply_setting(config, setting);
  config.simulation.backend = backend_of(shared.backend);
  if (shared.threads > 0) omp_set_num_threads(shared.threads);
}

// ---- run and the single stages -----------------------------------------------------------------

struct RunArguments {
  SharedOptions shared;
  RunRequest request;
  std::string from, until, unit, inlet;
  ReadArguments read;
  bool print_config = false;
};

void add_run_command(CLI::App& app, RunArguments& run) {
  CLI::App& command = *app.add_subcommand(
      "run",
      "every stage, from the input to the report\n"
      "INPUT: a DICOM folder or file, a volume (.nrrd .nhdr .mha .mhd .nii .nii.gz .vti), a\n"
      "lumen surface (.stl .vtp .ply .obj), or phantom:NAME[,key=value...]; none with a preset of\n"
      "the seed paper's experiments (paper-...)");
  command.add_option("INPUT", run.request.input, "scan, surface or phantom");
  command.add_option("-o,--output", run.request.case_folder, "the case's folder")
      ->type_name("CASE");
  command.add_option("--name", run.request.case_name,
                     "the case's name in the report; otherwise a hash of the input");
  command.add_option("--from", run.from, "run this stage and those after it again")
      ->type_name("STAGE");
  command
      .add_option("--until", run.until,
                  "last stage: segmentation, centerline, meshing, simulation or report")
      ->type_name("STAGE");
  add_read_options(command, run.read);
  add_unit_option(command, run.unit);
  command
      .add_option(
          "--inlet", run.inlet,
          "where blood comes in: a point in LPS [mm], or of a surface the number of an open\n"
          "end as `angio inspect` lists them; otherwise told by the tree's shape")
      ->type_name("X,Y,Z|END");
  command.add_flag("--force", run.request.force, "run everything again, into any folder");
  command.add_flag(
      "--keep-link", run.request.keep_link,
      "keep the input's path in source.private.json and, of a DICOM scan, the lumen as\n"
      "DICOM SEG in segmentation.private.dcm (mode 0600)");
  command.add_flag("--print-config", run.print_config, "print every option in force and end");
  add_run_options(command, run.shared);
}

int do_run(RunArguments& run) {
  apply_options(run.request.config, run.shared);
  apply_read_options(run.request.config, run.read);
  if (!run.unit.empty()) apply_setting(run.request.config, "input.unit=" + run.unit);
  if (run.inlet.find(',') != std::string::npos)
    apply_setting(run.request.config, "centerline.inlet_lps_mm=[" + run.inlet + "]");
  else if (!run.inlet.empty())
    apply_setting(run.request.config, "centerline.inlet_end=" + run.inlet);
  if (run.print_config) {
    fmt::print("{}", to_toml(run.request.config));
    return int(ExitCode::done);
  }
  if (run.request.input.empty()) run.request.input = default_input(run.request.config);
  if (run.request.input.empty() || run.request.case_folder.empty())
    throw Error(ExitCode::usage,
                "`angio run` needs an INPUT, before any --set, and -o CASE. See "
                "`angio run --help`");
  check_experiment_input(run.request.config, run.request.input);
  if (!run.from.empty()) run.request.from = parse_stage(run.from);
  if (!run.until.empty()) run.request.until = parse_stage(run.until);
  if (run.request.from && *run.request.from > run.request.until)
    throw Error(ExitCode::usage, "--from names a stage after --until");
  Reporter reporter(run.shared.style());
  reporter.result(run_case(run.request, reporter).string());
  return int(ExitCode::done);
}

struct StageCommand {
  const char* verb;
  Stage stage;
  const char* help;
};
constexpr StageCommand kStageCommands[] = {
    {"segment", Stage::segmentation, "find the lumen in the case's volume again"},
    {"centerline", Stage::centerline, "find the centreline and its radii again"},
    {"mesh", Stage::meshing, "mesh the lumen and place the balloon again"},
    {"simulate", Stage::simulation, "inflate, hold and deflate the balloon again"},
    {"report", Stage::report, "make the pictures and the report again"},
};

/// The key of the first setting that has changed; empty: none has.
std::string changed_key(const std::string& before, const std::string& after) {
  std::istringstream lines(after);
  for (std::string line; std::getline(lines, line);)
    if (("\n" + before).find("\n" + line + "\n") == std::string::npos)
      return line.substr(0, line.find(" = "));
  return {};
}

/// What a stage sees that is not run must stay as it was, or its files would be another case's.
void refuse_foreign_settings(const Config& before, const Config& after,
                             const StageCommand& command) {
  const auto refuse = [&](const std::string& key, const char* reader) {
    if (!key.empty())
      throw Error(ExitCode::usage,
                  fmt::format("{} belongs to {}, which `angio {}` does not run. Use `angio run "
                              "INPUT -o CASE --set ...`",
                              key, reader, command.verb));
  };
  for (const StageDefinition& stage : stage_table(after))
    if (stage.stage < command.stage)
      refuse(changed_key(stage.settings_text(before), stage.settings_text(after)),
             fmt::format("the stage {}", stage.name).c_str());
  if (command.stage == Stage::segmentation)
    refuse(changed_key(InputSettings(before).text(), InputSettings(after).text()),
           "the reading of INPUT");
}

int do_stage_again(const StageCommand& command, const SharedOptions& shared,
                   const fs::path& case_folder) {
  RunRequest request;
  request.case_folder = case_folder;
  request.config = case_config(CaseFolder(case_folder));
  apply_options(request.config, shared);
  refuse_foreign_settings(case_config(CaseFolder(case_folder)), request.config, command);
  request.from = command.stage;
  request.until = command.stage;
  Reporter reporter(shared.style());
  reporter.result(run_case(request, reporter).string());
  return int(ExitCode::done);
}

// ---- batch -------------------------------------------------------------------------------------

struct BatchArguments {
  SharedOptions shared;
  BatchRequest request;
};

void add_batch_command(CLI::App& app, BatchArguments& batch) {
  CLI::App& command = *app.add_subcommand(
      "batch",
      "a cohort: every row of a CSV manifest is a case\n"
      "columns: case,input and any configuration keys (balloon.length_mm, ...)");
  auto& r = batch.request;
  command.add_option("MANIFEST", r.manifest, "CSV file with a header")->required();
  command.add_option("-o,--output", r.folder, "folder of the cases and the summary")->required();
  command.add_option("-j,--jobs", r.jobs, "cases at a time, 1 to 256")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command.add_option("--retry", r.retries, "further tries of a case that failed, 0 to 10")
      ->check(CLI::Range(0, 10))
      ->capture_default_str();
  command.add_flag("--resume", r.resume,
                   "leave out the cases that are done with these very options and input");
  add_run_options(command, batch.shared);
}

int do_batch(BatchArguments& batch) {
  Config config;  // refuses wrong options before the first case
  apply_options(config, batch.shared);
  config.validate();
  auto& words = batch.request.arguments;
  if (!batch.shared.config_file.empty())
    words.insert(words.end(), {"--config", batch.shared.config_file});
  for (const std::string& preset : batch.shared.presets)
    words.insert(words.end(), {"--preset", preset});
  if (!batch.shared.balloon.empty()) words.insert(words.end(), {"--balloon", batch.shared.balloon});
  if (!batch.shared.catalogue.empty())
    words.insert(words.end(), {"--catalogue", batch.shared.catalogue});
  if (!batch.shared.contact.empty()) words.insert(words.end(), {"--contact", batch.shared.contact});
  for (const std::string& setting : batch.shared.settings)
    words.insert(words.end(), {"--set", setting});
  words.insert(words.end(), {"--backend", batch.shared.backend, "--quiet"});
  batch.request.threads = batch.shared.threads;
  batch.request.config = config;
  batch.request.program = fs::read_symlink("/proc/self/exe");
  Reporter reporter(batch.shared.style());
  const int failed = run_batch(batch.request, reporter);
  reporter.result((batch.request.folder / "summary.csv").string());
  return int(failed > 0 ? ExitCode::some_cases_failed : ExitCode::done);
}

// ---- completion and manual, for packages -----------------------------------------------------

struct ShellArguments {
  std::string shell;
};

void add_description_commands(CLI::App& app, ShellArguments& arguments) {
  CLI::App& completion = *app.add_subcommand("completion", "a shell's completion script");
  completion.add_option("SHELL", arguments.shell)->required();
  completion.group("");  // hidden
  app.add_subcommand("manual", "the manual page")->group("");
}

int do_describe(const CLI::App& app, const ShellArguments& arguments) {
  std::vector<std::string> stages;
  for (const StageDefinition& stage : stage_table({})) stages.emplace_back(stage.name);
  const ProgramDescription program =
      describe(app, {{"--preset", preset_names()}, {"--from", stages}, {"--until", stages}});
  fmt::print("{}", app.got_subcommand("manual") ? manual_page(program, kVersion)
                                                : completion_script(program, arguments.shell));
  return int(ExitCode::done);
}

// ---- the program -------------------------------------------------------------------------------

/// CLI11 writes several lines; CONTRACT wants one, with exit code 64.
int report_usage_error(const CLI::App& app, const CLI::ParseError& error,
                       const std::string& first_word) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
  std::string text = error.what();
  std::replace(text.begin(), text.end(), '\n', ' ');
  const std::vector<CLI::App*> used = app.get_subcommands();
  if (used.empty() && !first_word.empty()) text = "there is no command " + first_word;
  std::vector<std::string> known;
  const CLI::App& scope = used.empty() ? app : *used.front();
  for (const CLI::Option* option : scope.get_options())
    for (const std::string& long_name : option->get_lnames()) known.push_back("--" + long_name);
  for (const CLI::App* command : scope.get_subcommands({})) known.push_back(command->get_name());
  const std::string word = text.substr(text.find_last_of(' ') + 1);
  const std::string guess = guess_name(word, known);
  fmt::print(stderr, "angio: {}{}. See `angio{} --help`\n", text,
             guess.empty() || guess == word ? "" : fmt::format(" (did you mean {}?)", guess),
             used.empty() ? "" : " " + used.front()->get_name());
  return int(ExitCode::usage);
}

int dispatch(int argc, char** argv) {
  CLI::App app{
      "angio: from a rotational angiography to what a balloon does to the artery.\n"
      "Lengths in mm, pressures in atm, coordinates LPS. Not for clinical use."};
  app.set_version_flag("--version", "angio " + version_with_commit());
  app.require_subcommand(1);

  RunArguments run;
  add_run_command(app, run);
  std::vector<SharedOptions> stage_options(std::size(kStageCommands));
  fs::path case_folder;
  for (std::size_t i = 0; i < std::size(kStageCommands); ++i) {
    CLI::App& command = *app.add_subcommand(kStageCommands[i].verb, kStageCommands[i].help);
    command.add_option("CASE", case_folder, "the case's folder")->required();
    add_run_options(command, stage_options[i]);
  }
  InspectArguments inspect_arguments;
  CLI::App& inspect = add_inspect_command(app, inspect_arguments);
  viewer::ViewOptions view_options;
  CLI::App& view = *app.add_subcommand("view", "the desktop viewer");
  view.add_option("CASE", case_folder, "the case's folder")->required();
  view.add_option("--screenshot", view_options.screenshot, "write this PNG instead of a window");
  view.add_option("--frame", view_options.frame, "frame shown first; -1: the peak")
      ->capture_default_str();
  PhantomArguments phantom;
  add_phantom_command(app, phantom);
  InflateArguments inflate;
  add_inflate_command(app, inflate);
  BatchArguments batch;
  add_batch_command(app, batch);
  bool doctor_json = false;
  CLI::App& doctor = *app.add_subcommand("doctor", "what this computer has, and what will be used");
  doctor.add_flag("--json", doctor_json, "as JSON");
  ShellArguments shell;
  add_description_commands(app, shell);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return report_usage_error(app, error, argc > 1 && argv[1][0] != '-' ? argv[1] : "");
  }
  if (app.got_subcommand("run")) return do_run(run);
  for (std::size_t i = 0; i < std::size(kStageCommands); ++i)
    if (app.got_subcommand(kStageCommands[i].verb))
      return do_stage_again(kStageCommands[i], stage_options[i], case_folder);
  if (app.got_subcommand(&inspect)) return do_inspect(inspect_arguments);
  if (app.got_subcommand(&view)) {
    viewer::view_case(case_folder, view_options);
    return int(ExitCode::done);
  }
  if (app.got_subcommand("phantom")) return do_phantom(phantom);
  if (app.got_subcommand("inflate")) return do_inflate(inflate);
  if (app.got_subcommand("batch")) return do_batch(batch);
  if (app.got_subcommand(&doctor)) {
    fmt::print("{}", examine_computer(doctor_json));
    return int(ExitCode::done);
  }
  return do_describe(app, shell);
}

int fail(ExitCode code, const std::string& message) {
  fmt::print(stderr, "angio: {}\n", message);
  return int(code);
}

}  // namespace

int run_command_line(int argc, char** argv) {
  catch_interrupts();
  try {
    return dispatch(argc, argv);
  } catch (const Error& error) {
    return fail(error.exit_code(), error.what());
  } catch (const std::bad_alloc&) {
    return fail(ExitCode::unavailable,
                "not enough memory for this input. Close other programs, or crop the volume");
  } catch (const fs::filesystem_error& error) {
    return fail(ExitCode::io,
                fmt::format("reading or writing failed ({})", error.code().message()));
  } catch (const std::exception& error) {
    return fail(ExitCode::internal,
                fmt::format("a bug of this program ({}). Please report it", error.what()));
  }
}

}  // namespace angio::pipeline
