#include "pipeline/cli/batch.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <iterator>
#include <list>
#include <regex>
#include <thread>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/available_memory.hpp"
#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/cli/batch_memory.hpp"
#include "pipeline/cli/batch_outcome.hpp"
#include "pipeline/experiments/paper_input.hpp"
#include "pipeline/experiments/workflow.hpp"
#include "pipeline/stages/case_progress.hpp"
#include "pipeline/stages/require_backend.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;

namespace {

// ---- plan --------------------------------------------------------------------------------------

/// How far a row's case has come, with its input and options as they are now.
CaseProgress progress_of(const BatchRequest& request, const BatchCase& batch_case) {
  RunRequest run;
  run.input = batch_case.input;
  run.case_folder = request.folder / batch_case.name;
  run.case_name = batch_case.name;
  run.keep = request.keep;
  run.until = request.until;
  run.config = request.config;
  SharedOptions options = row_options(request.shared, batch_case);
  options.threads = 0;
  apply_options(run.config, options);
  if (run.input.empty()) run.input = default_input(run.config);
  return case_progress(workflow_of(run.config), run);
}

CasePlan plan_case(const BatchRequest& request, const BatchCase& batch_case) {
  using Action = CasePlan::Action;
  using State = CaseProgress::State;
  const Outcome last = last_outcome(request.folder, batch_case);
  if (request.only_failed) {
    if (last.status != "failed") return {Action::skip, "it has not failed: " + last.status, false};
  }
  CaseProgress progress;
  try {
    progress = progress_of(request, batch_case);
  } catch (const Error& error) {  // the case's own run says what is wrong
    return {Action::run, error.what(), false};
  }
  switch (progress.state) {
    case State::not_begun:
      return {Action::run, last.status == "failed" ? "it failed the last time" : "new", false};
    case State::of_another:
      if (was_done(request.folder, batch_case))
        return {Action::run, "its input has changed: it is made anew", false, true};
      return {Action::run, "its folder holds something else, so that it will fail", false};
    case State::begun:
      return {Action::resume, progress.next, false};
    case State::done:
      break;
  }
  if (request.resume) return {Action::skip, "done", true};
  const bool comes_back = progress.is_minimal && request.keep == Keep::all;
  return {Action::run,
          comes_back
              ? "done before: what --keep minimal removed is made again (--resume leaves it out)"
              : "done before: nothing changes (--resume leaves it out)",
          false};
}

// ---- processes ---------------------------------------------------------------------------------

/// The last line of a log is the one line that every failure prints.
std::string last_line(const fs::path& log) {
  std::string text = fs::exists(log) ? read_text(log) : std::string();
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text.substr(text.find_last_of("\n\r") + 1);
}

struct RunningCase {
  std::size_t index = 0;     ///< in the manifest
  std::uint64_t memory = 0;  ///< that it may take [bytes]
  ChildProgram program;
};

bool is_interrupted() {
  try {
    throw_if_interrupted();
    return false;
  } catch (const Interrupted&) {
    return true;
  }
}

/// @param replaces  what the row's folder holds
ChildProgram start_case(const BatchRequest& request, const BatchCase& batch_case, int threads,
                        bool replaces) {
  ProgramCall call;
  call.file = request.program;
  call.log = request.folder / "logs" / (batch_case.name + ".log");
  call.arguments = {"run"};
  if (!batch_case.input.empty()) call.arguments.push_back(batch_case.input);
  call.arguments.insert(call.arguments.end(),
                        {"-o", (request.folder / batch_case.name).string(), "--name",
                         batch_case.name, "--hide-input", "--threads", std::to_string(threads)});
  const std::vector<std::string> options = command_line_of(row_options(request.shared, batch_case));
  call.arguments.insert(call.arguments.end(), options.begin(), options.end());
  call.arguments.insert(call.arguments.end(), request.arguments.begin(), request.arguments.end());
  if (replaces) call.arguments.emplace_back("--force");
  if (request.keep == Keep::minimal)
    call.arguments.insert(call.arguments.end(), {"--keep", "minimal"});
  if (request.until != Stage::report)
    call.arguments.insert(call.arguments.end(), {"--until", name(request.until)});
  return ChildProgram(call);
}

int exit_code_of(const ChildResult& result) {
  return result.signal == 0 ? result.exit_status : 128 + result.signal;
}

/// Whether a further try may end otherwise: not where data, options or the command are at fault.
bool may_end_otherwise(int exit_code) {
  constexpr ExitCode kForGood[] = {ExitCode::usage, ExitCode::bad_data, ExitCode::no_input,
                                   ExitCode::bad_config};
  return std::none_of(std::begin(kForGood), std::end(kForGood),
                      [&](ExitCode code) { return int(code) == exit_code; });
}

/// Why a case has failed: the one line that every failure prints, or what killed it.
std::string reason_of(const ChildResult& result, const fs::path& log) {
  if (result.signal == SIGKILL)
    return "killed by signal 9 (was memory short? Fewer --jobs need less)";
  if (result.signal != 0) return fmt::format("ended by signal {}", result.signal);
  return result.exit_status == 0 ? std::string() : last_line(log);
}

/// Runs cases, some at a time, until none is left or the user asks to stop.
class Batch {
 public:
  Batch(const BatchRequest& request, std::vector<BatchCase> cases, Reporter& reporter)
      : request_(request),
        reporter_(reporter),
        cases_(std::move(cases)),
        outcomes_(cases_.size()),
        threads_(request.threads > 0 ? request.threads
                                     : std::max(1, omp_get_max_threads() / request.jobs)) {
    const bool looks = request.resume || request.only_failed;  // otherwise each case finds out
    const std::vector<CasePlan> plan =
        looks ? plan_batch(request, cases_) : std::vector<CasePlan>(cases_.size());
    for (const CasePlan& one : plan) replaces_.push_back(one.replaces);
    for (std::size_t c = cases_.size(); c-- > 0;) {
      if (plan[c].action != CasePlan::Action::skip)
        waiting_.push_back(c);
      else
        outcomes_[c] = last_outcome(request.folder, cases_[c]);
      if (plan[c].is_done) outcomes_[c] = {"done", 0, outcomes_[c].tries, ""};
    }
    chosen_ = waiting_;
    for (std::size_t c = 0; c < cases_.size(); ++c)
      if (plan[c].is_done) mark_done(request.folder, cases_[c]);
  }

  BatchResult run() {
    if (!waiting_.empty() && request_.until >= Stage::simulation)
      require_backend(backend_of(request_.shared.backend));
    make_folder(request_.folder / "logs");
    const FolderLock lock(request_.folder / "logs", lock_kind());
    if (lock.is_refused())
      throw IoError(fmt::format("another batch is at work in {} (two would spoil each other's "
                                "records). Wait for it, or choose another -o",
                                request_.folder.string()),
                    ExitCode::cannot_create);
    while (!running_.empty() || (!waiting_.empty() && !interrupted_)) {
      while (!interrupted_ && !waiting_.empty() && int(running_.size()) < request_.jobs &&
             start_next()) {
      }
      std::this_thread::sleep_for(kLookAgain);
      if (!interrupted_ && is_interrupted()) {
        for (const RunningCase& one : running_) one.program.ask_to_end();
        interrupted_ = true;
      }
      take_ended();
    }
    sum_up();
    if (interrupted_) throw Interrupted();
    BatchResult result;
    for (const std::size_t c : chosen_) {
      if (outcomes_[c].status == "done") continue;
      ++result.failed;
      result.worth_another_try += may_end_otherwise(outcomes_[c].exit_code) ? 1 : 0;
    }
    return result;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kLookAgain{20};
  static constexpr std::chrono::seconds kSumUpAgain{5};

  /// Shards run beside each other; a batch of all rows runs alone.
  [[nodiscard]] FolderLock::Kind lock_kind() const {
    return request_.shard.count > 1 ? FolderLock::Kind::shared : FolderLock::Kind::own;
  }

  /// By what it has taken before, what others have, or its input's size.
  [[nodiscard]] std::uint64_t memory_for(const BatchCase& one) const {
    const std::uint64_t before = memory_taken(request_.folder / one.name);
    if (before > 0) return before;
    return most_taken_ > 0 ? most_taken_ : memory_guess(one.input);
  }

  /// @return false: there is no memory for one more at present
  bool start_next() {
    const std::size_t c = waiting_.back();
    const std::uint64_t memory = memory_for(cases_[c]);
    if (!memory_.has_room_for(memory)) {
      if (!std::exchange(is_short_, true))
        reporter_.note(
            fmt::format("{} of {} cases at a time: more would need more memory than is "
                        "free",
                        running_.size(), request_.jobs));
      return false;
    }
    memory_.take(memory);
    waiting_.pop_back();
    ++outcomes_[c].tries;
    outcomes_[c] = {"started", -1, outcomes_[c].tries, "it is at work"};
    write_outcome(request_.folder, cases_[c], {"started", -1, outcomes_[c].tries, ""});
    running_.push_back({c, memory, start_case(request_, cases_[c], threads_, replaces_[c])});
    return true;
  }

  void take_ended() {
    for (auto one = running_.begin(); one != running_.end();) {
      const auto result = one->program.result();
      if (result) {
        memory_.give_back(one->memory);
        most_taken_ =
            std::max(most_taken_, memory_taken(request_.folder / cases_[one->index].name));
        take(one->index, *result);
      }
      one = result ? running_.erase(one) : std::next(one);
    }
  }

  void take(std::size_t c, const ChildResult& result) {
    const int exit_code = exit_code_of(result);
    const std::string& name = cases_[c].name;
    Outcome& outcome = outcomes_[c];
    outcome.exit_code = exit_code;
    const bool was_stopped = interrupted_ || exit_code == int(ExitCode::interrupted);
    outcome.status = exit_code == 0 ? "done" : (was_stopped ? "interrupted" : "failed");
    outcome.reason = reason_of(result, request_.folder / "logs" / (name + ".log"));
    if (outcome.status == "failed" && outcome.tries <= request_.retries &&
        may_end_otherwise(exit_code))
      waiting_.push_back(c);
    reporter_.note(fmt::format("{}: {}{}", name, outcome.status,
                               outcome.reason.empty() ? "" : ", " + outcome.reason));
    write_outcome(request_.folder, cases_[c], outcome);
    // It reads every case: of thousands that end one after another not each time.
    if (Clock::now() - last_summary_ > kSumUpAgain) sum_up();
  }

  void sum_up() {
    last_summary_ = Clock::now();
    write_summary(request_.folder, summary_file(request_), cases_, outcomes_);
  }

  const BatchRequest& request_;
  Reporter& reporter_;
  std::vector<BatchCase> cases_;
  std::vector<Outcome> outcomes_;
  int threads_;
  std::vector<bool> replaces_;        // what the row's folder holds, shape [cases]
  std::vector<std::size_t> waiting_;  // the next one last
  std::vector<std::size_t> chosen_;   // to be run in this call
  std::list<RunningCase> running_;
  MemoryBudget memory_{available_memory_bytes()};
  Clock::time_point last_summary_;
  std::uint64_t most_taken_ = 0;  // by a case of this call [bytes]
  bool is_short_ = false;
  bool interrupted_ = false;
};

}  // namespace

Shard parse_shard(const std::string& text) {
  static const std::regex kForm("([0-9]{1,6})/([0-9]{1,6})");
  std::smatch parts;
  if (std::regex_match(text, parts, kForm)) {
    const Shard shard{std::stoi(parts[1]), std::stoi(parts[2])};
    if (shard.number >= 1 && shard.number <= shard.count) return shard;
  }
  throw Error(ExitCode::usage, fmt::format("--shard {} is no part (write i/n, i from 1 to n: "
                                           "--shard 2/5)",
                                           text));
}

std::vector<BatchCase> rows_of_shard(const std::vector<BatchCase>& cases, const Shard& shard) {
  std::vector<BatchCase> rows;
  for (auto c = std::size_t(shard.number - 1); c < cases.size(); c += std::size_t(shard.count))
    rows.push_back(cases[c]);
  return rows;
}

fs::path summary_file(const BatchRequest& request) {
  const Shard& shard = request.shard;
  return request.folder / (shard.count == 1
                               ? "summary.csv"
                               : fmt::format("summary-{}-of-{}.csv", shard.number, shard.count));
}

std::vector<CasePlan> plan_batch(const BatchRequest& request, const std::vector<BatchCase>& cases) {
  std::vector<CasePlan> plans;
  for (const BatchCase& batch_case : cases) {
    throw_if_interrupted();
    plans.push_back(plan_case(request, batch_case));
  }
  return plans;
}

BatchResult run_batch(const BatchRequest& request, std::vector<BatchCase> cases,
                      Reporter& reporter) {
  end_in_own_time();  // after its cases
  return Batch(request, std::move(cases), reporter).run();
}

int summarize_batch(const BatchRequest& request, const std::vector<BatchCase>& cases) {
  std::vector<Outcome> outcomes;
  for (const BatchCase& batch_case : cases)
    outcomes.push_back(last_outcome(request.folder, batch_case));
  write_summary(request.folder, summary_file(request), cases, outcomes);
  return int(std::count_if(outcomes.begin(), outcomes.end(),
                           [](const Outcome& outcome) { return outcome.status != "done"; }));
}

}  // namespace angio::pipeline
