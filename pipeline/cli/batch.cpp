#include "pipeline/cli/batch.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <list>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/child_process.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "formats/html.hpp"
#include "pipeline/experiments/paper_input.hpp"
#include "pipeline/experiments/workflow.hpp"
#include "pipeline/stages/run_case.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

// ---- outcomes
// ------------------------------------------------------------------------------------

struct Outcome {
  std::string status = "not run";  // done, failed, not run
  int exit_code = -1;
  int tries = 0;
  std::string reason;  // the last line that the case printed
};

constexpr std::array<const char*, 15> kSummaryMetrics = {"/lesion/mld_mm",
                                                         "/lesion/reference_diameter_mm",
                                                         "/lesion/diameter_stenosis_percent",
                                                         "/lesion/length_mm",
                                                         "/balloon/nominal_diameter_mm",
                                                         "/balloon/peak_pressure_atm",
                                                         "/balloon/peak_diameter_mm",
                                                         "/peak/mld_mm",
                                                         "/result/mld_mm",
                                                         "/result/diameter_stenosis_percent",
                                                         "/result/acute_gain_mm",
                                                         "/result/recoil_percent",
                                                         "/simulation/max_penetration_mm",
                                                         "/flow/ffr_before",
                                                         "/flow/ffr_after"};

formats::CsvRow summary_header() {
  formats::CsvRow header = {"case", "status", "exit_code", "tries"};
  for (const std::string metric : kSummaryMetrics) {
    std::string column = metric.substr(1);
    std::replace(column.begin(), column.end(), '/', '.');
    header.push_back(column);
  }
  header.insert(header.end(), {"case_status", "reason"});
  return header;
}

formats::CsvRow summary_row(const fs::path& folder, const BatchCase& batch_case,
                            const Outcome& outcome) {
  formats::CsvRow row = {batch_case.name, outcome.status,
                         outcome.exit_code < 0 ? "" : std::to_string(outcome.exit_code),
                         std::to_string(outcome.tries)};
  json metrics;
  const fs::path file = folder / batch_case.name / "metrics.json";
  if (outcome.status == "done" && fs::exists(file))
    metrics = json::parse(read_text(file), nullptr, false);
  for (const char* metric : kSummaryMetrics) {
    const json::json_pointer pointer(metric);
    const bool known =
        metrics.is_object() && metrics.contains(pointer) && metrics.at(pointer).is_number();
    row.push_back(known ? fmt::format("{:.4g}", metrics.at(pointer).get<double>()) : "");
  }
  const auto words = [&](const char* key) {
    return metrics.is_object() && metrics.contains(key) && metrics[key].is_string()
               ? metrics[key].get<std::string>()
               : std::string();
  };
  row.push_back(words("status"));
  row.push_back(outcome.reason.empty() ? words("status_reason") : outcome.reason);
  return row;
}

void write_summary(const fs::path& folder, const std::vector<BatchCase>& cases,
                   const std::vector<Outcome>& outcomes) {
  std::vector<formats::CsvRow> rows = {summary_header()};
  for (std::size_t c = 0; c < cases.size(); ++c)
    rows.push_back(summary_row(folder, cases[c], outcomes[c]));
  std::string csv;
  std::string html =
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>angio batch</title><style>"
      "body{font:15px system-ui,sans-serif;margin:2em}table{border-collapse:collapse}"
      "td,th{border:1px solid #bbb;padding:.3em .6em;text-align:right}"
      "td:first-child,td:last-child,th{text-align:left}.failed{background:#fdd}"
      "</style><h1>Cases</h1><table>\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    html += fmt::format("<tr class=\"{}\">", r == 0 ? "head" : formats::escape_html(rows[r][1]));
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      csv += (c == 0 ? "" : ",") + formats::csv_cell(rows[r][c]);
      const bool links = r > 0 && c == 0 && rows[r][1] == "done";
      const std::string text = formats::escape_html(rows[r][c]);
      const std::string shown =
          links ? fmt::format("<a href=\"{0}/report/index.html\">{0}</a>", text) : text;
      html += r == 0 ? "<th>" + shown + "</th>" : "<td>" + shown + "</td>";
    }
    csv += "\n";
    html += "</tr>\n";
  }
  write_text_atomically(folder / "summary.csv", csv);
  write_text_atomically(
      folder / "summary.html",
      html + "</table><p>mm, mm2, atm, percent. Not for clinical use.</p></html>\n");
}

/// Is a row done, with its input and options as they are now?
bool is_done(const BatchRequest& request, const BatchCase& batch_case) {
  try {
    RunRequest run;
    run.input = batch_case.input;
    run.case_folder = request.folder / batch_case.name;
    run.case_name = batch_case.name;
    run.config = request.config;
    SharedOptions options = row_options(request.shared, batch_case);
    options.threads = 0;
    apply_options(run.config, options);
    if (run.input.empty()) run.input = default_input(run.config);
    return is_case_done(workflow_of(run.config), run);
  } catch (const Error&) {  // the case's own run says what is wrong
    return false;
  }
}

// ---- processes
// -----------------------------------------------------------------------------------

/// The last line of a log is the one line that every failure prints.
std::string last_line(const fs::path& log) {
  std::string text = fs::exists(log) ? read_text(log) : std::string();
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text.substr(text.find_last_of("\n\r") + 1);
}

struct RunningCase {
  std::size_t index = 0;  ///< in the manifest
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

ChildProgram start_case(const BatchRequest& request, const BatchCase& batch_case, int threads) {
  ProgramCall call;
  call.file = request.program;
  call.log = request.folder / "logs" / (batch_case.name + ".log");
  call.arguments = {"run"};
  if (!batch_case.input.empty()) call.arguments.push_back(batch_case.input);
  call.arguments.insert(call.arguments.end(),
                        {"-o", (request.folder / batch_case.name).string(), "--name",
                         batch_case.name, "--threads", std::to_string(threads)});
  const std::vector<std::string> options = command_line_of(row_options(request.shared, batch_case));
  call.arguments.insert(call.arguments.end(), options.begin(), options.end());
  call.arguments.insert(call.arguments.end(), request.arguments.begin(), request.arguments.end());
  return ChildProgram(call);
}

int exit_code_of(const ChildResult& result) {
  return result.signal == 0 ? result.exit_status : 128 + result.signal;
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
    for (std::size_t c = cases_.size(); c-- > 0;) {
      if (request.resume && is_done(request, cases_[c]))
        outcomes_[c] = {"done", 0, 0, "done before"};
      else
        waiting_.push_back(c);
    }
  }

  int run() {
    make_folder(request_.folder / "logs");
    while (!running_.empty() || (!waiting_.empty() && !interrupted_)) {
      while (!interrupted_ && !waiting_.empty() && int(running_.size()) < request_.jobs)
        start_next();
      std::this_thread::sleep_for(kLookAgain);
      if (!interrupted_ && is_interrupted()) {
        for (const RunningCase& one : running_) one.program.ask_to_end();
        interrupted_ = true;
      }
      take_ended();
    }
    write_summary(request_.folder, cases_, outcomes_);
    if (interrupted_) throw Interrupted();
    return int(std::count_if(outcomes_.begin(), outcomes_.end(),
                             [](const Outcome& o) { return o.status != "done"; }));
  }

 private:
  static constexpr std::chrono::milliseconds kLookAgain{20};

  void start_next() {
    const std::size_t c = waiting_.back();
    waiting_.pop_back();
    ++outcomes_[c].tries;
    running_.push_back({c, start_case(request_, cases_[c], threads_)});
  }

  void take_ended() {
    for (auto one = running_.begin(); one != running_.end();) {
      const auto result = one->program.result();
      if (result) take(one->index, exit_code_of(*result));
      one = result ? running_.erase(one) : std::next(one);
    }
  }

  void take(std::size_t c, int exit_code) {
    const std::string& name = cases_[c].name;
    Outcome& outcome = outcomes_[c];
    outcome.exit_code = exit_code;
    outcome.status = exit_code == 0 ? "done" : "failed";
    outcome.reason = exit_code == 0 ? "" : last_line(request_.folder / "logs" / (name + ".log"));
    if (exit_code != 0 && outcome.tries <= request_.retries && !interrupted_) waiting_.push_back(c);
    reporter_.note(fmt::format("{}: {}{}", name, outcome.status,
                               outcome.reason.empty() ? "" : ", " + outcome.reason));
    write_summary(request_.folder, cases_, outcomes_);
  }

  const BatchRequest& request_;
  Reporter& reporter_;
  std::vector<BatchCase> cases_;
  std::vector<Outcome> outcomes_;
  int threads_;
  std::vector<std::size_t> waiting_;  // the next one last
  std::list<RunningCase> running_;
  bool interrupted_ = false;
};

}  // namespace

int run_batch(const BatchRequest& request, std::vector<BatchCase> cases, Reporter& reporter) {
  return Batch(request, std::move(cases), reporter).run();
}

}  // namespace angio::pipeline
