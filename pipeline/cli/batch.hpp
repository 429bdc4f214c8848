#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/cli/manifest.hpp"
#include "pipeline/config/config.hpp"
#include "pipeline/stages/reporter.hpp"

namespace angio::pipeline {

struct BatchRequest {
  std::filesystem::path folder;        ///< gets CASE/, logs/CASE.log, summary.csv, summary.html
  int jobs = 1;                        ///< cases at a time, [1, 256]
  int threads = 0;                     ///< a case's threads; 0: the computer's, shared out
  int retries = 0;                     ///< further tries of a case that failed, [0, 10]
  bool resume = false;                 ///< leave out cases that are done: see is_case_done()
  Config config;                       ///< what a case's options change
  SharedOptions shared;                ///< of every case
  std::filesystem::path program;       ///< this executable
  std::vector<std::string> arguments;  ///< also passed on to every `angio run`
};

/// Runs every case in a process of its own; a failure stops none of the others.
/// @return how many cases failed
int run_batch(const BatchRequest& request, std::vector<BatchCase> cases, Reporter& reporter);

}  // namespace angio::pipeline
