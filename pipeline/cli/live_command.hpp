#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

#include "pipeline/cli/shared_options.hpp"
#include "viewer/live.hpp"

namespace angio::pipeline {

struct LiveArguments {
  std::filesystem::path case_folder;
  std::string wall = "case";
  viewer::LiveOptions options;
  SharedOptions shared;  ///< --threads, --quiet and --json alone
};

CLI::App& add_live_command(CLI::App& app, LiveArguments& arguments);
/// Opens the window, and says at its end how fast it was. @return the exit code
int do_live(const LiveArguments& arguments);

}  // namespace angio::pipeline
