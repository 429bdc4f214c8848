#pragma once

#include <filesystem>
#include <span>

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

int do_stage_again(const StageCommand& command, const SharedOptions& shared,
                   const std::filesystem::path& case_folder);

}  // namespace angio::pipeline
