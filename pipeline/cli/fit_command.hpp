#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

#include "pipeline/cli/shared_options.hpp"
#include "reconstruction/tree_fit.hpp"
#include "segmentation/read_run.hpp"

namespace angio::pipeline {

struct FitArguments {
  std::filesystem::path case_folder, run, folder;
  segmentation::ReadOptions read;
  reconstruction::TreeFitOptions fit;
  SharedOptions shared;  ///< --quiet and --json alone
};

/// `angio fit`: the lines of a case fitted to the X-ray frames that its volume was made of.
CLI::App& add_fit_command(CLI::App& app, FitArguments& arguments);
int do_fit(const FitArguments& arguments);

}  // namespace angio::pipeline
