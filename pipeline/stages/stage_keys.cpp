#include "pipeline/stages/stage_keys.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/atomic_file.hpp"
#include "formats/case_file.hpp"
#include "pipeline/version.hpp"

namespace angio::pipeline {
namespace {

using formats::case_file::kReport;
constexpr const char* kNotice =
    "<p id=\"stale\" style=\"margin:0 0 1em;padding:1em;background:#b00;color:#fff\"><b>This "
    "report is "
    "stale.</b> Settings or files of the case have changed since it was made. Run <code>angio "
    "run</code> again.</p>\n";

/// The inputs as the stages before have left them.
std::map<std::string, std::string> recorded_inputs(const StageDefinition& stage,
                                                   const RunRecord& run) {
  std::map<std::string, std::string> inputs;
  for (const auto& [producer, record] : run.stages)
    if (producer < stage.stage)
      for (const auto& output : record.outputs)
        if (names_file(stage.inputs, output.first)) inputs.insert(output);
  return inputs;
}

bool has_result(const StageRecord& record) {
  return record.status == "done" || record.status == "given" || record.status == "skipped" ||
         record.status == "failed";
}

std::string without_notice(std::string report) {
  const std::size_t notice = report.find(kNotice);
  return notice == std::string::npos ? report : report.erase(notice, std::string(kNotice).size());
}

}  // namespace

std::string stage_key(const StageDefinition& stage, const Config& config, const RunRecord& run,
                      const std::map<std::string, std::string>& inputs) {
  std::string text =
      fmt::format("{}\n{}\n{}{}\n", version_with_commit(), stage.name, stage.settings_text(config),
                  to_json(stage.sees(config, run)).dump());
  for (const auto& [file, hash] : inputs) text += file + " " + hash + "\n";
  return sha256_of_text(text);
}

std::string recorded_key(const StageDefinition& stage, const Config& config, const RunRecord& run) {
  return stage_key(stage, config, run, recorded_inputs(stage, run));
}

void mark_stale(const CaseFolder& case_folder, const Workflow& workflow, const Config& config,
                RunRecord& run) {
  bool is_one_stale = false;
  for (const StageDefinition& stage : workflow.stages) {
    const auto found = run.stages.find(stage.stage);
    if (!stage.work || found == run.stages.end() || !has_result(found->second)) continue;
    StageRecord& record = found->second;
    const bool is_whole =
        std::all_of(record.outputs.begin(), record.outputs.end(),
                    [&](const auto& output) { return case_folder.exists(output.first); });
    record.is_stale = is_one_stale || !is_whole || record.key != recorded_key(stage, config, run);
    is_one_stale = is_one_stale || record.is_stale;
  }
}

std::string report_hash(const CaseFolder& case_folder) {
  return sha256_of_text(without_notice(read_text(case_folder.path(kReport))));
}

void mark_report(const CaseFolder& case_folder, bool is_stale) {
  if (!case_folder.exists(kReport)) return;
  const std::string text = read_text(case_folder.path(kReport));
  std::string marked = without_notice(text);
  if (is_stale) {
    constexpr const char* kBody = "<body>\n";
    const std::size_t body = marked.find(kBody);
    marked.insert(body == std::string::npos ? 0 : body + std::string(kBody).size(), kNotice);
  }
  if (marked != text) write_text_atomically(case_folder.path(kReport), marked);
}

}  // namespace angio::pipeline
