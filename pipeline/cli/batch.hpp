#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/case/stage.hpp"
#include "pipeline/cli/manifest.hpp"
#include "pipeline/config/config.hpp"
#include "pipeline/stages/minimal_case.hpp"
#include "pipeline/stages/reporter.hpp"

namespace angio::pipeline {

/// One of `count` parts of a manifest's rows.
struct Shard {
  int number = 1;  ///< [1, count]
  int count = 1;
};

/// "i/n". @throws Error (64)
Shard parse_shard(const std::string& text);
/// Every n-th row, from the i-th on: the shards are disjoint, and together they are all rows.
std::vector<BatchCase> rows_of_shard(const std::vector<BatchCase>& cases, const Shard& shard);

struct BatchRequest {
  std::filesystem::path folder;        ///< gets CASE/, logs/CASE.log and .json, and the summary
  int jobs = 1;                        ///< cases at a time, [1, 256]
  int threads = 0;                     ///< a case's threads; 0: the computer's, shared out
  int retries = 0;                     ///< further tries of a case that failed, [0, 10]
  bool resume = false;                 ///< leave out cases that are done: see case_progress()
  bool only_failed = false;            ///< run those alone whose last run has failed
  Keep keep = Keep::all;               ///< which files of a case stay when it is done
  Stage until = Stage::report;         ///< a case is done when this stage is
  Shard shard;                         ///< whose rows the summary is of; it has its own name
  Config config;                       ///< what a case's options change
  SharedOptions shared;                ///< of every case
  std::filesystem::path program;       ///< this executable
  std::vector<std::string> arguments;  ///< also passed on to every `angio run`
};

/// What is to be done with a row.
struct CasePlan {
  enum class Action { run, resume, skip };
  Action action = Action::run;
  std::string reason;
  bool is_done = false;   ///< left out, because it is done
  bool replaces = false;  ///< what this batch has made of another input
};

/// Looks at every case's files. Nothing is written.
std::vector<CasePlan> plan_batch(const BatchRequest& request, const std::vector<BatchCase>& cases);

/// How the cases of one call have ended.
struct BatchResult {
  int failed = 0;
  int worth_another_try = 0;  ///< of these: neither data nor options were at fault
};

/// Runs every case that is not left out in a process of its own; a failure stops none of the
/// others.
/// @param cases  the shard's
BatchResult run_batch(const BatchRequest& request, std::vector<BatchCase> cases,
                      Reporter& reporter);

/// Writes the summary of what former runs, also of shards, have left.
/// @return how many cases are not done
int summarize_batch(const BatchRequest& request, const std::vector<BatchCase>& cases);

/// summary.csv, or that of the shard.
std::filesystem::path summary_file(const BatchRequest& request);

}  // namespace angio::pipeline
