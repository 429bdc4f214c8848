#pragma once

#include <CLI/App.hpp>
#include <filesystem>

namespace angio::pipeline {

struct FigureArguments {
  std::filesystem::path case_folder, folder;
  bool quiet = false, json = false;
};

CLI::App& add_figure_command(CLI::App& app, FigureArguments& arguments);
int do_figure(const FigureArguments& arguments);

}  // namespace angio::pipeline
