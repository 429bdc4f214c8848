#include "pipeline/cli/batch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <omp.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "pipeline/experiments/workflow.hpp"
#include "pipeline/stages/run_case.hpp"

extern char** environ;  // POSIX: the environment handed to each case's process

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

std::string html_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '&')
      escaped += "&amp;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

// ---- outcomes
// ------------------------------------------------------------------------------------

struct Outcome {
  std::string status = "not run";  // done, failed, not run
  int exit_code = -1;
  int tries = 0;
  std::string reason;  // the last line that the case printed
};

constexpr std::array<const char*, 12> kSummaryMetrics = {"/lesion/mld_mm",
                                                         "/lesion/reference_diameter_mm",
                                                         "/lesion/diameter_stenosis_percent",
                                                         "/lesion/length_mm",
                                                         "/balloon/nominal_diameter_mm",
                                                         "/balloon/peak_pressure_atm",
                                                         "/balloon/peak_diameter_mm",
                                                         "/result/mld_mm",
                                                         "/result/diameter_stenosis_percent",
                                                         "/result/acute_gain_mm",
                                                         "/result/recoil_percent",
                                                         "/simulation/max_penetration_mm"};

formats::CsvRow summary_header() {
  formats::CsvRow header = {"case", "status", "exit_code", "tries"};
  for (const std::string metric : kSummaryMetrics) {
    std::string column = metric.substr(1);
    std::replace(column.begin(), column.end(), '/', '.');
    header.push_back(column);
  }
  header.push_back("reason");
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
  row.push_back(outcome.reason);
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
    html += fmt::format("<tr class=\"{}\">", r == 0 ? "head" : html_text(rows[r][1]));
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      csv += (c == 0 ? "" : ",") + formats::csv_cell(rows[r][c]);
      const bool links = r > 0 && c == 0 && rows[r][1] == "done";
      const std::string text = html_text(rows[r][c]);
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
    for (const std::string& setting : batch_case.settings) apply_setting(run.config, setting);
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

pid_t start_case(const BatchRequest& request, const BatchCase& batch_case, int threads) {
  std::vector<std::string> words = {request.program.string(),
                                    "run",
                                    batch_case.input,
                                    "-o",
                                    (request.folder / batch_case.name).string(),
                                    "--name",
                                    batch_case.name,
                                    "--threads",
                                    std::to_string(threads)};
  words.insert(words.end(), request.arguments.begin(), request.arguments.end());
  for (const std::string& setting : batch_case.settings) {
    words.push_back("--set");
    words.push_back(setting);
  }
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const fs::path log = request.folder / "logs" / (batch_case.name + ".log");
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                   0644);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  pid_t process = -1;
  const int error =
      posix_spawn(&process, request.program.c_str(), &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0)
    throw InternalError(
        fmt::format("cannot start a process for a case ({})", std::strerror(error)));
  return process;
}

int exit_code_of(int wait_status) {
  return WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 128 + WTERMSIG(wait_status);
}

std::vector<std::string> settings_of_row(const formats::CsvRow& header,
                                         const formats::CsvRow& row) {
  std::vector<std::string> result;
  for (std::size_t c = 0; c < header.size(); ++c)
    if (header[c] != "case" && header[c] != "input" && c < row.size() && !row[c].empty())
      result.push_back(header[c] + "=" + row[c]);
  return result;
}

std::size_t column_of(const formats::CsvRow& header, const char* column) {
  const auto found = std::find(header.begin(), header.end(), column);
  if (found == header.end())
    throw InputError(
        fmt::format("the manifest has no column '{}' (its first row must name the "
                    "columns case,input[,section.key...])",
                    column));
  return std::size_t(found - header.begin());
}

}  // namespace

std::vector<BatchCase> read_manifest(const fs::path& file) {
  if (!fs::exists(file))
    throw InputError(fmt::format("there is no {} (no such manifest)", file.string()),
                     ExitCode::no_input);
  const std::vector<formats::CsvRow> rows = formats::parse_csv(read_text(file));
  if (rows.size() < 2)
    throw InputError(
        fmt::format("{} has no cases (a header case,input and a row a case are "
                    "needed)",
                    file.string()));
  const std::size_t name_column = column_of(rows[0], "case");
  const std::size_t input_column = column_of(rows[0], "input");
  std::vector<BatchCase> cases;
  std::set<std::string> names;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    if (rows[r].size() <= std::max(name_column, input_column))
      throw InputError(fmt::format("row {} of the manifest is too short", r + 1));
    BatchCase batch_case{rows[r][name_column], rows[r][input_column],
                         settings_of_row(rows[0], rows[r])};
    if (!std::regex_match(batch_case.name, std::regex("[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}")) ||
        batch_case.name == "logs")
      throw InputError(
          fmt::format("row {} of the manifest: a case's name is made of letters, "
                      "digits, '.', '_' and '-' (it names a folder)",
                      r + 1));
    if (!names.insert(batch_case.name).second)
      throw InputError(fmt::format("row {} of the manifest: the case {} is there twice", r + 1,
                                   batch_case.name));
    if (!batch_case.input.starts_with("phantom:") && fs::path(batch_case.input).is_relative())
      batch_case.input = (fs::absolute(file).parent_path() / batch_case.input).string();
    cases.push_back(std::move(batch_case));
  }
  return cases;
}

int run_batch(const BatchRequest& request, Reporter& reporter) {
  const std::vector<BatchCase> cases = read_manifest(request.manifest);
  make_folder(request.folder / "logs");
  const int threads =
      request.threads > 0 ? request.threads : std::max(1, omp_get_max_threads() / request.jobs);

  std::vector<Outcome> outcomes(cases.size());
  std::vector<std::size_t> waiting;
  for (std::size_t c = cases.size(); c-- > 0;) {
    if (request.resume && is_done(request, cases[c]))
      outcomes[c] = {"done", 0, 0, "done before"};
    else
      waiting.push_back(c);
  }

  std::map<pid_t, std::size_t> running;
  bool interrupted = false;
  while (!running.empty() || (!waiting.empty() && !interrupted)) {
    while (!interrupted && !waiting.empty() && int(running.size()) < request.jobs) {
      const std::size_t c = waiting.back();
      waiting.pop_back();
      ++outcomes[c].tries;
      running[start_case(request, cases[c], threads)] = c;
    }
    int status = 0;
    const pid_t ended = waitpid(-1, &status, 0);
    try {
      throw_if_interrupted();
    } catch (const Interrupted&) {
      if (!interrupted)
        for (const auto& [process, unused] : running) kill(process, SIGTERM);
      interrupted = true;
    }
    const auto found = running.find(ended);
    if (found == running.end()) continue;
    const std::size_t c = found->second;
    running.erase(found);
    Outcome& outcome = outcomes[c];
    outcome.exit_code = exit_code_of(status);
    outcome.status = outcome.exit_code == 0 ? "done" : "failed";
    outcome.reason =
        outcome.exit_code == 0 ? "" : last_line(request.folder / "logs" / (cases[c].name + ".log"));
    if (outcome.exit_code != 0 && outcome.tries <= request.retries && !interrupted)
      waiting.push_back(c);
    reporter.note(fmt::format("{}: {}{}", cases[c].name, outcome.status,
                              outcome.reason.empty() ? "" : ", " + outcome.reason));
    write_summary(request.folder, cases, outcomes);
  }
  write_summary(request.folder, cases, outcomes);
  if (interrupted) throw Interrupted();
  return int(std::count_if(outcomes.begin(), outcomes.end(),
                           [](const Outcome& o) { return o.status != "done"; }));
}

}  // namespace angio::pipeline
