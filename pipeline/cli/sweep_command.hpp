#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cli/batch.hpp"
#include "pipeline/cli/shared_options.hpp"

namespace angio::pipeline {

struct SweepArguments {
  std::filesystem::path base;
  std::vector<std::string> axes;  ///< "section.key=a,b,c"
  bool reports = false;           ///< make each variant's report, too
  SharedOptions shared;
  BatchRequest request;
};

void add_sweep_command(CLI::App& app, SweepArguments& sweep);
int do_sweep(SweepArguments& sweep);

}  // namespace angio::pipeline
