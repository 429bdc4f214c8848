#include "pipeline/case_status.hpp"

#include <fmt/format.h>

#include "pipeline/metrics.hpp"
#include "pipeline/stage_work.hpp"

namespace angio::pipeline {
namespace {

constexpr const char* kPlacement = "meshing/placement.json";
constexpr Stage kTreating[] = {Stage::segmentation, Stage::centerline, Stage::meshing,
                               Stage::simulation};

std::string status_of(const RunRecord& record, Stage stage) {
  const auto found = record.stages.find(stage);
  return found == record.stages.end() ? std::string() : found->second.status;
}

}  // namespace

bool is_fresh(const CaseFolder& case_folder, const RunRecord& record, Stage stage) {
  return status_of(record, stage) == "done" &&
         record.stages.at(stage).inputs == case_folder.hashes(stage_inputs(stage));
}

bool is_untreated(const CaseFolder& case_folder) {
  return case_folder.exists(kPlacement) &&
         !read_json(case_folder.path(kPlacement)).contains("balloon");
}

CaseStatus case_status(const CaseFolder& case_folder, const RunRecord& record) {
  for (const Stage stage : kTreating) {
    if (status_of(record, stage) != "failed") continue;
    const std::vector<std::string>& told = record.stages.at(stage).warnings;
    return {"failed", fmt::format("the stage {} failed{}", name(stage),
                                  told.empty() ? "" : ": " + told.front())};
  }
  for (const Stage stage : kTreating)
    if (status_of(record, stage) == "done" && !is_fresh(case_folder, record, stage))
      return {"stale", fmt::format("a stage before {0} has been run again since {0} was. Run "
                                   "`angio run` again",
                                   name(stage))};
  if (status_of(record, Stage::meshing) != "done" || !case_folder.exists(kPlacement)) return {};
  const nlohmann::json placement = read_json(case_folder.path(kPlacement));
  const CaseStatus found{placement.value("status", "done"), placement.value("status_reason", "")};
  const bool ended =
      status_of(record, Stage::simulation) == "done" || !placement.contains("balloon");
  return ended ? found : CaseStatus{};
}

}  // namespace angio::pipeline
