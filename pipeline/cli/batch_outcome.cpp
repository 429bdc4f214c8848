#include "pipeline/cli/batch_outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "formats/html.hpp"
#include "pipeline/case/case_folder.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

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

json metrics_of(const fs::path& folder, const BatchCase& batch_case) {
  const fs::path file = folder / batch_case.name / "metrics.json";
  return fs::exists(file) ? json::parse(read_text(file), nullptr, false) : json();
}

/// A text of a JSON object; empty if it has none.
std::string words_of(const json& node, const char* key) {
  const bool has = node.is_object() && node.contains(key) && node.at(key).is_string();
  return has ? node.at(key).get<std::string>() : std::string();
}

fs::path record_file(const fs::path& folder, const BatchCase& batch_case) {
  return folder / "logs" / (batch_case.name + ".json");
}

/// What the row says, by which an edited one is known. The batch's own options are not in it, so
/// that a summary needs none.
std::string row_hash(const BatchCase& batch_case) {
  std::string text = batch_case.input_cell + "\n" + batch_case.preset + "\n" + batch_case.balloon;
  for (const std::string& setting : batch_case.settings) text += "\n" + setting;
  return sha256_of_text(text);
}

/// Of a case that no batch has recorded.
Outcome outcome_of_files(const json& metrics) {
  const std::string status = words_of(metrics, "status");
  if (status == "failed")
    return {status, int(ExitCode::bad_data), 0, words_of(metrics, "status_reason")};
  if (status == "stale") return {status, -1, 0, words_of(metrics, "status_reason")};
  if (!status.empty()) return {"done", 0, 0, ""};
  return {};
}

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
  const json metrics = outcome.status == "done" ? metrics_of(folder, batch_case) : json();
  for (const char* metric : kSummaryMetrics) {
    const json::json_pointer pointer(metric);
    const bool known =
        metrics.is_object() && metrics.contains(pointer) && metrics.at(pointer).is_number();
    row.push_back(known ? fmt::format("{:.4g}", metrics.at(pointer).get<double>()) : "");
  }
  row.push_back(words_of(metrics, "status"));
  row.push_back(outcome.reason.empty() ? words_of(metrics, "status_reason") : outcome.reason);
  return row;
}

}  // namespace

void write_outcome(const fs::path& folder, const BatchCase& batch_case, const Outcome& outcome) {
  const json record = {{"case", batch_case.name},
                       {"status", outcome.status},
                       {"exit_code", outcome.exit_code < 0 ? json() : json(outcome.exit_code)},
                       {"tries", outcome.tries},
                       {"reason", outcome.reason.empty() ? json() : json(outcome.reason)},
                       {"row_sha256", row_hash(batch_case)}};
  write_text_atomically(record_file(folder, batch_case),
                        record.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

Outcome last_outcome(const fs::path& folder, const BatchCase& batch_case) {
  const fs::path file = record_file(folder, batch_case);
  const json metrics = metrics_of(folder, batch_case);
  const json record = fs::exists(file) ? json::parse(read_text(file), nullptr, false) : json();
  if (words_of(record, "status").empty()) return outcome_of_files(metrics);
  Outcome outcome;
  outcome.status = words_of(record, "status");
  outcome.reason = words_of(record, "reason");
  if (record.contains("exit_code") && record["exit_code"].is_number_integer())
    outcome.exit_code = record["exit_code"];
  if (record.contains("tries") && record["tries"].is_number_integer())
    outcome.tries = record["tries"];
  if (outcome.status == "started") outcome.reason = "it is still at work, or was killed";
  if (outcome.status != "done") return outcome;
  if (!metrics.is_object()) return {"not run", -1, 0, "its folder is gone"};
  if (words_of(record, "row_sha256") != row_hash(batch_case))
    return {"stale", -1, 0, "its row has changed since. Run the batch again with --resume"};
  return outcome;
}

void write_summary(const fs::path& folder, const fs::path& file,
                   const std::vector<BatchCase>& cases, const std::vector<Outcome>& outcomes) {
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
  write_text_atomically(file, csv);
  write_text_atomically(
      fs::path(file).replace_extension(".html"),
      html + "</table><p>mm, mm2, atm, percent. Not for clinical use.</p></html>\n");
}

}  // namespace angio::pipeline
