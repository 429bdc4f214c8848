#include "pipeline/case/case_status.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/metrics.hpp"

namespace angio::pipeline {
namespace {

using formats::case_file::kPlacement;
using formats::case_file::kQuality;
using formats::case_file::kSummary;
constexpr Stage kTreating[] = {Stage::reconstruction, Stage::segmentation, Stage::centerline,
                               Stage::meshing, Stage::simulation};

const StageRecord* record_of(const RunRecord& record, Stage stage) {
  const auto found = record.stages.find(stage);
  return found == record.stages.end() ? nullptr : &found->second;
}

/// Why nobody can tell whether the vessels are there, or how narrow: of frames that tell too
/// little. Empty of everything else.
std::string doubt_of_vessels(const StageFiles& files, const RunRecord& record,
                             const nlohmann::json& placement) {
  if (!record.is(Stage::reconstruction, "done") || !files.exists(kQuality)) return {};
  const nlohmann::json quality = read_json(files.path(kQuality));
  if (const auto doubt = quality.find("doubt"); doubt != quality.end() && doubt->is_string())
    return doubt->get<std::string>();
  const auto lesion = placement.find("lesion");
  if (quality.value("method", "") == "few-views" && lesion != placement.end() &&
      lesion->value("mld_below_resolution", false))
    return "the throat is thinner than a voxel, in a volume that was fitted to few frames: what is "
           "faint there may be missing, so that it bounds no stenosis. Compare it with the frames "
           "(reconstruction/frames.nrrd, the report's sheet)";
  return {};
}

}  // namespace

bool is_untreated(const CaseFolder& case_folder) {
  return case_folder.exists(kPlacement) &&
         !read_json(case_folder.path(kPlacement)).contains("balloon");
}

void refuse_untreated(const CaseFolder& case_folder) {
  if (!is_untreated(case_folder)) return;
  const std::string reason = read_json(case_folder.path(kPlacement)).value("status_reason", "");
  throw InputError(
      fmt::format("{} has no simulation, because {}. Try {}", case_folder.root().string(),
                  reason.empty() ? "no balloon could be placed" : reason, kToTreatAnyway),
      ExitCode::no_input);
}

CaseStatus case_status(const StageFiles& files, const RunRecord& record) {
  for (const Stage stage : kTreating) {
    if (!record.is(stage, "failed")) continue;
    const std::vector<std::string>& told = record.stages.at(stage).warnings;
    return {"failed", fmt::format("the stage {} failed{}", name(stage),
                                  told.empty() ? "" : ": " + told.front())};
  }
  for (const Stage stage : kTreating) {
    const StageRecord* found = record_of(record, stage);
    if (found && found->is_stale)
      return {"stale", fmt::format("settings or files that the stage {0} depends on have changed "
                                   "since {0} was run. Run `angio run` again",
                                   name(stage))};
  }
  if (!record.is(Stage::meshing, "done") || !files.exists(kPlacement)) return {};
  const nlohmann::json placement = read_json(files.path(kPlacement));
  CaseStatus found{placement.value("status", "done"), placement.value("status_reason", "")};
  if (const std::string doubt = doubt_of_vessels(files, record, placement); !doubt.empty())
    found = {"not_determined", doubt};
  if (!placement.contains("balloon")) return found;
  if (record.is(Stage::simulation, "skipped")) {
    found.reason += "; it gives no result there (the simulation's warning says why)";
    return found;
  }
  if (!record.is(Stage::simulation, "done")) return {};
  if (found.status != "done" || !files.exists(kSummary)) return found;
  const std::string reason = read_json(files.path(kSummary)).value("guard_reason", "");
  return reason.empty() ? found : CaseStatus{"not_determined", reason};
}

}  // namespace angio::pipeline
