#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "pipeline/cli/variants.hpp"

namespace angio::pipeline {

struct SweepArguments {
  std::vector<std::string> axes;  ///< "section.key=a,b,c"
  VariantArguments variants;
};

void add_sweep_command(CLI::App& app, SweepArguments& sweep);
int do_sweep(SweepArguments& sweep);

}  // namespace angio::pipeline
