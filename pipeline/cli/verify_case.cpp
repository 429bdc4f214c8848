#include "pipeline/cli/verify_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "pipeline/experiments/workflow.hpp"
#include "pipeline/stages/case_progress.hpp"
#include "pipeline/stages/stage_keys.hpp"
#include "pipeline/version.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace file = formats::case_file;
namespace {

bool is_done(const StageRecord& stage) {
  return stage.status == "done" || stage.status == "given" || stage.status == "skipped";
}

/// The judging of one case.
class Judge {
 public:
  explicit Judge(const CaseFolder& folder) : folder_(folder), record_(folder.read_record()) {}

  Verification judge() {
    check_record();
    const std::optional<Config> config = read_config();
    const Workflow& workflow = workflow_of(config.value_or(Config{}));
    for (const StageDefinition& stage : workflow.stages) {
      if (!stage.work || !applies(stage, record_)) continue;
      const StageRecord& entry = record_.stages[stage.stage];
      check_end(stage, entry);
      check_files(stage, entry);
      if (is_done(entry)) check_age(stage, entry, config);
    }
    if (!other_builds_.empty())
      found_.notes.push_back(fmt::format(
          "made by angio {}, this is {}: whether its settings have changed since was not judged",
          *other_builds_.begin(), version_with_commit()));
    return found_;
  }

 private:
  void add(const char* kind, const std::string& place, const std::string& text) {
    found_.findings.push_back({kind, place, text});
  }

  void check_record() {
    if (!folder_.is_record_intact())
      add("changed", file::kRun, "its content is not what the last run left");
    for (const auto& [name, hash] : record_.files)
      check_file(name, hash, "its content is not what the last run left");
  }

  std::optional<Config> read_config() {
    try {
      return case_config(folder_);
    } catch (const Error& error) {
      add("damaged", file::kSettings, error.what());
      return std::nullopt;
    }
  }

  void check_end(const StageDefinition& stage, const StageRecord& entry) {
    if (is_done(entry)) return;
    const std::string why = entry.warnings.empty() ? "" : ": " + entry.warnings.front();
    add("unfinished", stage.name,
        entry.status == "not run" ? "it was not run" : "it ended as " + entry.status + why);
  }

  void check_files(const StageDefinition& stage, const StageRecord& entry) {
    for (const auto& [name, hash] : entry.outputs) {
      const bool is_removed =
          std::find(entry.removed.begin(), entry.removed.end(), name) != entry.removed.end();
      if (is_removed && !folder_.exists(name)) continue;
      check_file(name, hash, fmt::format("its content is not what the stage {} left", stage.name));
    }
  }

  void check_file(const std::string& name, const std::string& hash, const std::string& why) {
    if (!fs::is_regular_file(folder_.path(name))) return add("missing", name, "run.json lists it");
    ++found_.file_count;
    const bool is_report = name == file::kReport;  // may have been marked as stale
    const std::string now = is_report ? report_hash(folder_) : sha256_of_path(folder_.path(name));
    if (now != hash) add("changed", name, why);
  }

  /// Was the stage made from these settings and files?
  void check_age(const StageDefinition& stage, const StageRecord& entry,
                 const std::optional<Config>& config) {
    const bool is_of_others =
        std::any_of(entry.inputs.begin(), entry.inputs.end(), [&](const auto& input) {
          const auto hash = hash_recorded(input.first);
          return hash && *hash != input.second;
        });
    if (entry.is_stale || is_of_others || is_one_stale_) {
      is_one_stale_ = true;
      return add("stale", stage.name, "what it was made from has changed since");
    }
    if (!entry.build.empty() && entry.build != version_with_commit()) {
      other_builds_.insert(entry.build);
      return;
    }
    is_one_stale_ = config && entry.key != recorded_key(stage, *config, record_);
    if (is_one_stale_)
      add("stale", stage.name, "its settings, or what it was made from, have changed since");
  }

  /// As the stage that makes a file has recorded it.
  [[nodiscard]] std::optional<std::string> hash_recorded(const std::string& name) const {
    for (const auto& [stage, entry] : record_.stages) {
      const auto found = entry.outputs.find(name);
      if (found != entry.outputs.end()) return found->second;
    }
    return std::nullopt;
  }

  const CaseFolder& folder_;
  RunRecord record_;
  Verification found_;
  std::set<std::string> other_builds_;
  bool is_one_stale_ = false;  // then all after it are, too
};

}  // namespace

Verification verify_case(const CaseFolder& case_folder) {
  if (!fs::is_regular_file(case_folder.path(file::kRun)))
    throw InputError(fmt::format("{} is no case (it has no run.json). Name the folder that `angio "
                                 "run -o` made",
                                 case_folder.root().string()),
                     ExitCode::no_input);
  return Judge(case_folder).judge();
}

}  // namespace angio::pipeline
