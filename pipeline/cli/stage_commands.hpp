#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "pipeline/case/stage.hpp"
#include "pipeline/cli/shared_options.hpp"

namespace angio::pipeline {

/// A command that runs one stage again.
struct StageCommand {
  const char* verb;
  Stage stage;
  const char* help;
};
std::span<const StageCommand> stage_commands();

/// How INPUT is read is as it was where the case's own files stand for it.
/// @throws Error (64) naming the setting that has changed, and the command
void refuse_other_input(const Config& before, const Config& after, const std::string& verb);

int do_stage_again(const StageCommand& command, const SharedOptions& shared,
                   const std::filesystem::path& case_folder);

}  // namespace angio::pipeline
