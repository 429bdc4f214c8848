#pragma once

#include <string>

#include "pipeline/cli/data_commands.hpp"
#include "pipeline/cli/shared_options.hpp"
#include "pipeline/stages/run_case.hpp"

namespace angio::pipeline {

struct RunArguments {
  SharedOptions shared;
  RunRequest request;
  std::string from, until, unit, inlet, calling;
  std::string keep = "all";
  ReadArguments read;
  bool print_config = false;
  bool hide_input = false;
};

void add_run_command(CLI::App& app, RunArguments& run);
int do_run(RunArguments& run);

struct ExperimentArguments {
  std::string name;  ///< "cloth", ...
  RunArguments run;
};
void add_experiment_command(CLI::App& app, ExperimentArguments& experiment);
int do_experiment(ExperimentArguments& experiment);

}  // namespace angio::pipeline
