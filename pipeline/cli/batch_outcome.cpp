#include "pipeline/cli/batch_outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/cli/batch_page.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

/// Null where there are none, or what is there is no JSON object.
json metrics_of(const fs::path& folder, const BatchCase& batch_case) {
  const fs::path file = folder / batch_case.name / "metrics.json";
  const json metrics = fs::exists(file) ? json::parse(read_text(file), nullptr, false) : json();
  return metrics.is_object() ? metrics : json();
}

/// A text of a JSON object; empty if it has none.
std::string words_of(const json& node, const char* key) {
  const bool has = node.is_object() && node.contains(key) && node.at(key).is_string();
  return has ? node.at(key).get<std::string>() : std::string();
}

fs::path record_file(const fs::path& folder, const BatchCase& batch_case) {
  return folder / "logs" / (batch_case.name + ".json");
}

fs::path done_file(const fs::path& folder, const BatchCase& batch_case) {
  return folder / "logs" / (batch_case.name + ".done");
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

/// What a case's own record says of it. A record may come from elsewhere.
void add_record(const fs::path& folder, SummaryCase& one) {
  const fs::path file = folder / one.name / "run.json";
  if (!fs::exists(file)) return;
  const json record = json::parse(read_text(file), nullptr, false);
  if (!record.is_object()) return;
  one.version = words_of(record, "version");
  if (record.contains("input")) one.input_sha256 = words_of(record["input"], "sha256");
  if (!record.contains("stages") || !record["stages"].is_object()) return;
  const auto number = [](const json& stage, const char* key) {
    return stage.contains(key) && stage[key].is_number() ? stage[key].get<double>() : 0.0;
  };
  for (const json& stage : record["stages"]) {
    if (!stage.is_object()) continue;
    one.seconds += number(stage, "seconds");
    one.peak_memory_mib = std::max(one.peak_memory_mib, number(stage, "peak_memory_mib"));
    if (!stage.contains("warnings") || !stage["warnings"].is_array()) continue;
    for (const json& warning : stage["warnings"])
      if (warning.is_string()) one.warnings.push_back(warning);
  }
}

SummaryCase summary_case(const fs::path& folder, const BatchCase& batch_case,
                         const Outcome& outcome) {
  SummaryCase one;
  one.name = batch_case.name;
  one.outcome = outcome;
  if (outcome.status == "done") one.metrics = metrics_of(folder, batch_case);
  one.case_status = words_of(one.metrics, "status");
  one.reason = outcome.reason.empty() ? words_of(one.metrics, "status_reason") : outcome.reason;
  if (outcome.status != "not run") add_record(folder, one);
  return one;
}

/// "/lesion/mld_mm" as "lesion.mld_mm".
std::string column_of(std::string pointer) {
  pointer.erase(0, 1);
  std::replace(pointer.begin(), pointer.end(), '/', '.');
  return pointer;
}

/// What a run took, and on what, is no part of a table that is the same wherever it was made.
bool is_of_machine(const std::string& column) {
  return column.find("wall_s") != std::string::npos || column == "/simulation/device" ||
         column.find("time_split") != std::string::npos ||
         column.find("frames_per_second") != std::string::npos ||
         column.find("real_time_factor") != std::string::npos;
}

/// Six digits of a measured number; counts whole, and words as they are.
std::string cell_of(const json& value) {
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (value.is_string()) return value.get<std::string>();
  return value.is_primitive() && !value.is_null() ? value.dump() : std::string();
}

/// Every value of metrics.json by its column, but those that have columns of their own.
std::map<std::string, std::string> further_cells(const SummaryCase& one) {
  std::map<std::string, std::string> cells;
  if (!one.metrics.is_object()) return cells;
  const json flat = one.metrics.flatten();  // items() only refers to it
  for (const auto& [pointer, value] : flat.items())
    if (!is_of_machine(pointer) && !cell_of(value).empty())
      cells[column_of(pointer)] = cell_of(value);
  for (const SummaryMeasure& measure : summary_measures()) cells.erase(column_of(measure.pointer));
  for (const char* column : {"status", "status_reason"}) cells.erase(column);
  return cells;
}

std::string csv_of(const std::vector<SummaryCase>& cases) {
  std::vector<std::map<std::string, std::string>> further;
  std::set<std::string> columns;
  for (const SummaryCase& one : cases) {
    further.push_back(further_cells(one));
    for (const auto& [column, cell] : further.back()) columns.insert(column);
  }
  std::vector<formats::CsvRow> rows = {{"case", "status", "exit_code", "tries"}};
  for (const SummaryMeasure& measure : summary_measures())
    rows[0].push_back(column_of(measure.pointer));
  rows[0].insert(rows[0].end(), {"case_status", "reason", "input_sha256", "version", "warnings"});
  rows[0].insert(rows[0].end(), columns.begin(), columns.end());
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const SummaryCase& one = cases[c];
    const int code = one.outcome.exit_code;
    formats::CsvRow& row = rows.emplace_back(formats::CsvRow{one.name, one.outcome.status,
                                                             code < 0 ? "" : std::to_string(code),
                                                             std::to_string(one.outcome.tries)});
    for (const SummaryMeasure& measure : summary_measures())
      row.push_back(cell_of(value_at(one, measure.pointer)));
    row.insert(row.end(), {one.case_status, one.reason, one.input_sha256, one.version,
                           std::to_string(one.warnings.size())});
    for (const std::string& column : columns) {
      const auto found = further[c].find(column);
      row.push_back(found == further[c].end() ? "" : found->second);
    }
  }
  std::string csv;
  for (const formats::CsvRow& row : rows)
    for (const std::string& cell : row)
      csv += formats::csv_cell(cell) + (&cell == &row.back() ? "\n" : ",");
  return csv;
}

json json_of(const SummaryCase& one) {
  const auto text = [](const std::string& words) { return words.empty() ? json() : json(words); };
  return {{"case", one.name},
          {"status", one.outcome.status},
          {"exit_code", one.outcome.exit_code < 0 ? json() : json(one.outcome.exit_code)},
          {"tries", one.outcome.tries},
          {"case_status", text(one.case_status)},
          {"reason", text(one.reason)},
          {"input_sha256", text(one.input_sha256)},
          {"version", text(one.version)},
          {"seconds", one.seconds},
          {"peak_memory_mib", one.peak_memory_mib},
          {"warnings", one.warnings},
          {"metrics", one.metrics}};
}

void write_figures(const fs::path& folder, const std::vector<SummaryCase>& cases) {
  for (const SummaryMeasure& measure : summary_measures()) {
    const std::string figure = spread_figure(cases, measure);
    const fs::path file = folder / "figures" / (column_of(measure.pointer) + ".svg");
    if (figure.empty())
      fs::remove(file);
    else
      write_text_atomically(file, figure);
  }
}

}  // namespace

void mark_done(const fs::path& folder, const BatchCase& batch_case) {
  if (!fs::exists(done_file(folder, batch_case)))
    write_text_atomically(done_file(folder, batch_case), "");
}

void write_outcome(const fs::path& folder, const BatchCase& batch_case, const Outcome& outcome) {
  if (outcome.status != "done") fs::remove(done_file(folder, batch_case));
  const json record = {{"case", batch_case.name},
                       {"status", outcome.status},
                       {"exit_code", outcome.exit_code < 0 ? json() : json(outcome.exit_code)},
                       {"tries", outcome.tries},
                       {"reason", outcome.reason.empty() ? json() : json(outcome.reason)},
                       {"row_sha256", row_hash(batch_case)}};
  write_text_atomically(record_file(folder, batch_case),
                        record.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
  if (outcome.status == "done") mark_done(folder, batch_case);
}

bool was_done(const fs::path& folder, const BatchCase& batch_case) {
  const fs::path file = record_file(folder, batch_case);
  return fs::exists(file) &&
         words_of(json::parse(read_text(file), nullptr, false), "status") == "done";
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
  std::vector<SummaryCase> summary;
  json all = json::array();
  for (std::size_t c = 0; c < cases.size(); ++c) {
    summary.push_back(summary_case(folder, cases[c], outcomes[c]));
    all.push_back(json_of(summary.back()));
  }
  write_text_atomically(file, csv_of(summary));
  write_text_atomically(fs::path(file).replace_extension(".json"),
                        all.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
  write_text_atomically(fs::path(file).replace_extension(".html"), summary_page(folder, summary));
  if (file.filename() != "summary.csv") return;  // a shard's
  write_text_atomically(folder / "sheet.html", quality_page(folder, summary));
  write_figures(folder, summary);
}

}  // namespace angio::pipeline
