#pragma once

#include <CLI/App.hpp>
#include <filesystem>

#include "pipeline/cli/shared_options.hpp"

namespace angio::pipeline {

struct FigureArguments {
  std::filesystem::path case_folder, folder;
  SharedOptions shared;  ///< --quiet and --json alone
};

CLI::App& add_figure_command(CLI::App& app, FigureArguments& arguments);
int do_figure(const FigureArguments& arguments);

}  // namespace angio::pipeline
