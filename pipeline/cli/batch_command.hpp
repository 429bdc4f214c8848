#pragma once

#include "pipeline/cli/batch.hpp"
#include "pipeline/cli/shared_options.hpp"

namespace angio::pipeline {

struct BatchArguments {
  std::filesystem::path manifest;
  SharedOptions shared;
  std::string shard;  ///< "i/n"; empty: all rows
  std::string keep = "all";
  std::string until;  ///< a stage; empty: all
  bool dry_run = false;
  bool for_engine = false;
  bool summary_only = false;
  BatchRequest request;
};

void add_batch_command(CLI::App& app, BatchArguments& batch);
int do_batch(BatchArguments& batch);

}  // namespace angio::pipeline
