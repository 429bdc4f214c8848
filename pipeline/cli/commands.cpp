#include "pipeline/cli/commands.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <regex>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/parallel.hpp"
#include "core/printable.hpp"
#include "core/text.hpp"
#include "pipeline/case/console.hpp"
#include "pipeline/case/stage.hpp"
#include "pipeline/cli/archive_commands.hpp"
#include "pipeline/cli/batch_command.hpp"
#include "pipeline/cli/bids_command.hpp"
#include "pipeline/cli/command_description.hpp"
#include "pipeline/cli/convert_command.hpp"
#include "pipeline/cli/data_commands.hpp"
#include "pipeline/cli/doctor.hpp"
#include "pipeline/cli/figure_command.hpp"
#include "pipeline/cli/film_command.hpp"
#include "pipeline/cli/fit_command.hpp"
#include "pipeline/cli/inflate_command.hpp"
#include "pipeline/cli/live_command.hpp"
#include "pipeline/cli/phantom_command.hpp"
#include "pipeline/cli/recommend_command.hpp"
#include "pipeline/cli/run_command.hpp"
#include "pipeline/cli/stage_commands.hpp"
#include "pipeline/cli/stale_note.hpp"
#include "pipeline/cli/sweep_command.hpp"
#include "pipeline/cli/verify_command.hpp"
#include "pipeline/version.hpp"
#include "viewer/view.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

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

ProgramDescription describe_program(const CLI::App& app) {
  std::vector<std::string> stages;
  for (int s = 0; s < kStageCount; ++s) stages.emplace_back(name(Stage(s)));
  return describe(app, {{"--preset", preset_names()}, {"--from", stages}, {"--until", stages}});
}

int do_describe(const CLI::App& app, const ShellArguments& arguments) {
  const ProgramDescription program = describe_program(app);
  fmt::print("{}", app.got_subcommand("manual") ? manual_page(program, kVersion)
                                                : completion_script(program, arguments.shell));
  return int(ExitCode::done);
}

/// Every command has the option; it is answered before the others are looked at.
void add_xml_options(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_group().empty())
      command->add_flag("--xml")->description(
          "print this command's parameters as XML, for 3D Slicer, and end");
}

/// @return the exit code, where a command's parameters are asked for
std::optional<int> answer_xml(const CLI::App& app, const std::vector<std::string>& words) {
  if (words.size() != 2 || words[1] != "--xml") return std::nullopt;
  const ProgramDescription program = describe_program(app);
  for (const CommandDescription& command : program.commands) {
    if (command.name != words[0]) continue;
    fmt::print("{}", slicer_xml(command, kVersion));
    return int(ExitCode::done);
  }
  return std::nullopt;
}

// ---- a case in a window, and the computer ------------------------------------------------------

struct ViewArguments {
  fs::path case_folder;
  viewer::ViewOptions options;
};

void add_view_command(CLI::App& app, ViewArguments& arguments) {
  CLI::App& view = *app.add_subcommand("view", "the desktop viewer");
  view.add_option("CASE", arguments.case_folder, "the case's folder")->required();
  view.add_option("--screenshot", arguments.options.screenshot,
                  "write this PNG instead of a window");
  view.add_option("--keys", arguments.options.keys,
                  "keys pressed at the start, by X's names: --keys m,period,F2")
      ->delimiter(',');
  view.add_option("--frame", arguments.options.frame, "frame shown first; -1: the peak")
      ->capture_default_str();
}

int do_view(const ViewArguments& arguments) {
  end_in_own_time();
  Reporter reporter(ReportStyle::lines);
  note_if_stale(arguments.case_folder, reporter);
  viewer::view_case(arguments.case_folder, arguments.options);
  return int(ExitCode::done);
}

void add_doctor_command(CLI::App& app, bool& as_json) {
  CLI::App& doctor = *app.add_subcommand("doctor", "what this computer has, and what will be used");
  doctor.add_flag("--json", as_json, "as JSON");
}

int do_doctor(bool as_json) {
  fmt::print("{}", examine_computer(as_json));
  return int(ExitCode::done);
}

// ---- the program -------------------------------------------------------------------------------

/// A value that CLI11 could not read, with what its option expects.
std::string conversion_fault(const CLI::App& scope, const std::string& text) {
  constexpr std::string_view kBegin = "Could not convert: ", kBetween = " = ";
  const std::size_t between = text.find(kBetween);
  if (!text.starts_with(kBegin) || between == std::string::npos) return text;
  const std::string name = text.substr(kBegin.size(), between - kBegin.size()),
                    value = text.substr(between + kBetween.size());
  std::string expected = "another kind of value";
  if (const CLI::Option* option = scope.get_option_no_throw(name)) {
    const std::string type = option->get_type_name();
    const bool is_list = type.find("...") != std::string::npos;
    expected = is_list                           ? "numbers, as " + type
               : type == "INT" || type == "UINT" ? "a whole number"
               : type == "FLOAT"                 ? "a number"
                                                 : "a number: " + type;
  }
  return fmt::format("{} {} cannot be used (expected {})", name, value, expected);
}

/// CLI11 writes several lines; docs/contract.md wants one, with exit code 64.
int report_usage_error(const CLI::App& app, const CLI::ParseError& error,
                       const std::string& first_word) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
  std::string text = error.what();
  std::replace(text.begin(), text.end(), '\n', ' ');
  const std::vector<CLI::App*> used = app.get_subcommands();
  if (!used.empty()) text = conversion_fault(*used.front(), text);
  text = std::regex_replace(text, std::regex("([0-9])\\.0{6}(?![0-9])"), "$1");  // of ranges
  if (used.empty() && !first_word.empty())
    text =
        (first_word.starts_with('-') ? "there is no option " : "there is no command ") + first_word;
  std::vector<std::string> known;
  const CLI::App& scope = used.empty() ? app : *used.front();
  for (const CLI::Option* option : scope.get_options())
    for (const std::string& long_name : option->get_lnames()) known.push_back("--" + long_name);
  for (const CLI::App* command : scope.get_subcommands({})) known.push_back(command->get_name());
  const std::string word = text.substr(text.find_last_of(' ') + 1);
  const std::string guess = guess_name(word, known);
  say("angio: {}{}. See `angio{} --help`\n", printable(text),
      guess.empty() || guess == word ? "" : fmt::format(" (did you mean {}?)", guess),
      used.empty() ? "" : " " + used.front()->get_name());
  return int(ExitCode::usage);
}

/// The commands, each with its arguments and what it does.
class Commands {
 public:
  explicit Commands(CLI::App& app) : app_(app) {}

  template <class Arguments, class Describe, class Action>
  void add(const Describe& describe, const Action& action) {
    auto arguments = std::make_shared<Arguments>();
    describe(app_, *arguments);
    actions_.emplace_back(app_.get_subcommands({}).back(),
                          [action, arguments] { return action(*arguments); });
  }
  void add_stage(const StageCommand& stage) {
    struct Arguments {
      SharedOptions options;
      fs::path case_folder;
    };
    add<Arguments>(
        [&](CLI::App& app, Arguments& arguments) {
          CLI::App& command = *app.add_subcommand(stage.verb, stage.help);
          command.add_option("CASE", arguments.case_folder, "the case's folder")->required();
          add_run_options(command, arguments.options);
        },
        [&stage](Arguments& arguments) {
          return do_stage_again(stage, arguments.options, arguments.case_folder);
        });
  }
  /// @return the exit code of the command that was given; nothing if it is none of these
  [[nodiscard]] std::optional<int> run() const {
    for (const auto& [command, action] : actions_)
      if (app_.got_subcommand(command)) return action();
    return std::nullopt;
  }

 private:
  CLI::App& app_;
  std::vector<std::pair<CLI::App*, std::function<int()>>> actions_;
};

/// What was asked for. A program called angio-COMMAND (a link to this one) is that command: so 3D
/// Slicer, which starts a file without arguments of ours, finds each command as a module.
std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  constexpr std::string_view kPrefix = "angio-";
  const std::string called = argc > 0 ? fs::path(argv[0]).filename().string() : "";
  if (called.starts_with(kPrefix)) words.insert(words.begin(), called.substr(kPrefix.size()));
  return words;
}

int dispatch(int argc, char** argv) {
  CLI::App app{
      "angio: from a rotational angiography to what a balloon does to the artery.\n"
      "Lengths in mm, pressures in atm, coordinates LPS. Not for clinical use."};
  app.set_version_flag("--version", "angio " + version_with_commit());
  app.require_subcommand(1);

  Commands commands(app);
  commands.add<RunArguments>(add_run_command, do_run);
  for (const StageCommand& stage : stage_commands()) commands.add_stage(stage);
  commands.add<InspectArguments>(add_inspect_command, do_inspect);
  commands.add<ViewArguments>(add_view_command, do_view);
  commands.add<LiveArguments>(add_live_command, do_live);
  commands.add<FilmArguments>(add_film_command, do_film);
  commands.add<FigureArguments>(add_figure_command, do_figure);
  commands.add<FitArguments>(add_fit_command, do_fit);
  commands.add<ConvertArguments>(add_convert_command, do_convert);
  commands.add<SendArguments>(add_send_command, do_send);
  commands.add<FetchArguments>(add_fetch_command, do_fetch);
  commands.add<PhantomArguments>(add_phantom_command, do_phantom);
  commands.add<InflateArguments>(add_inflate_command, do_inflate);
  commands.add<ExperimentArguments>(add_experiment_command, do_experiment);
  commands.add<BatchArguments>(add_batch_command, do_batch);
  commands.add<BidsArguments>(add_bids_command, do_bids);
  commands.add<SweepArguments>(add_sweep_command, do_sweep);
  commands.add<VerifyArguments>(add_verify_command, do_verify);
  commands.add<RecommendArguments>(add_recommend_command, do_recommend);
  commands.add<bool>(add_doctor_command, do_doctor);
  ShellArguments shell;
  add_description_commands(app, shell);

  add_xml_options(app);
  app.name(argc > 0 ? argv[0] : "angio");

  const std::vector<std::string> words = words_of(argc, argv);
  if (const std::optional<int> exit_code = answer_xml(app, words)) return *exit_code;
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::ParseError& error) {
    return report_usage_error(app, error, words.empty() ? "" : words[0]);
  }
  const std::optional<int> exit_code = commands.run();
  return exit_code ? *exit_code : do_describe(app, shell);
}

constexpr const char* kNoOutput =
    "standard output cannot be written (a full disk, or a closed pipe)";

int fail(ExitCode code, const std::string& message) {
  // A manifest's faults have a line each.
  std::string lines = printable(message.substr(0, message.find('\n')));
  for (auto at = message.find('\n'); at != std::string::npos;) {
    const auto end = message.find('\n', at + 1);
    lines += "\n" + printable(message.substr(at + 1, end - at - 1));
    at = end;
  }
  say("angio: {}\n", lines);
  return int(code);
}

}  // namespace

int run_command_line(int argc, char** argv) {
  catch_interrupts();
  try {
    const int exit_code = dispatch(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) return fail(ExitCode::io, kNoOutput);
    return exit_code;
  } catch (const Error& error) {
    end_in_own_time();  // it does end
    return fail(error.exit_code(), error.what());
  } catch (const std::bad_alloc&) {
    return fail(ExitCode::unavailable,
                "not enough memory for this input. Close other programs, or crop the volume");
  } catch (const std::system_error& error) {  // the file system's are among them
    return fail(ExitCode::io,
                fmt::format("reading or writing failed ({})", error.code().message()));
  } catch (const std::exception& error) {
    return fail(ExitCode::internal,
                fmt::format("a bug of this program ({}). Please report it", error.what()));
  }
}

}  // namespace angio::pipeline
