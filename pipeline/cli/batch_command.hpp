#pragma once

#include "pipeline/cli/batch.hpp"
#include "pipeline/cli/shared_options.hpp"

namespace angio::pipeline {

struct BatchArguments {
  SharedOptions shared;
  BatchRequest request;
};

void add_batch_command(CLI::App& app, BatchArguments& batch);
int do_batch(BatchArguments& batch);

}  // namespace angio::pipeline
