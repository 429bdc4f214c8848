#include "pipeline/cli/stage_commands.hpp"

#include <fmt/format.h>

#include <sstream>
#include <string>

#include "core/error.hpp"
#include "pipeline/cli/stale_note.hpp"
#include "pipeline/experiments/workflow.hpp"
#include "pipeline/stages/run_case.hpp"
#include "pipeline/stages/stage_settings.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

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

/// @param key  of a setting that may not change; empty: none has
void refuse(const std::string& key, const std::string& reader, const std::string& verb) {
  if (!key.empty())
    throw Error(ExitCode::usage,
                fmt::format("{} belongs to {}, which `angio {}` does not run. Use `angio run "
                            "INPUT -o CASE --set ...`",
                            key, reader, verb));
}

/// What a stage sees that is not run must stay as it was, or its files would be another case's.
void refuse_foreign_settings(const Config& before, const Config& after,
                             const StageCommand& command) {
  for (const StageDefinition& stage : workflow_of(after).stages)
    if (stage.stage < command.stage)
      refuse(changed_key(stage.settings_text(before), stage.settings_text(after)),
             fmt::format("the stage {}", stage.name), command.verb);
  if (command.stage == Stage::segmentation) refuse_other_input(before, after, command.verb);
}

}  // namespace

void refuse_other_input(const Config& before, const Config& after, const std::string& verb) {
  refuse(changed_key(InputSettings(before).text(), InputSettings(after).text()),
         "the reading of INPUT", verb);
}

std::span<const StageCommand> stage_commands() { return kStageCommands; }

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
  if (command.stage == Stage::report) note_if_stale(case_folder, reporter);
  reporter.result(run_case(workflow_of(request.config), request, reporter).string());
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
