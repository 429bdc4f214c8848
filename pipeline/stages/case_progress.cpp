#include "pipeline/stages/case_progress.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "core/error.hpp"
#include "core/printable.hpp"
#include "pipeline/case/input_folder.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/running_case.hpp"
#include "pipeline/stages/stage_keys.hpp"
#include "segmentation/read_run.hpp"
#include "segmentation/read_views.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

/// Whether INPUT is of X-ray frames: a rotational run, or views of a C-arm that stood still. What
/// cannot be read is refused by the stage that reads it.
bool is_run(const RunRequest& request, InputKind kind) {
  const std::string& input = request.input;
  if (!request.geometry.empty()) {
    if (kind != InputKind::volume)
      throw Error(ExitCode::usage,
                  "--geometry belongs to X-ray frames (DICOM, or a stack as a volume file); INPUT "
                  "is something else");
    if (!fs::is_regular_file(request.geometry))
      throw InputError(fmt::format("there is no geometry file {} (no such file). Check the path",
                                   request.geometry.string()),
                       ExitCode::no_input);
    return true;
  }
  if (kind != InputKind::volume || !is_dicom(input)) return false;
  try {
    return segmentation::is_rotational_run(input, request.config.input) ||
           segmentation::are_views(input, request.config.input);
  } catch (const InputError&) {
    return false;
  } catch (const OptionError&) {
    return false;
  }
}

/// Why a stage is not up to date; empty: it is.
std::string why_again(const StageDefinition& stage, const Config& config, const RunRecord& record,
                      const CaseFolder& folder) {
  const auto found = record.stages.find(stage.stage);
  const StageRecord entry = found == record.stages.end() ? StageRecord{} : found->second;
  const std::string key =
      stage_key(stage, config, record, hashes_as_left(folder, record, stage.inputs));
  if (!entry.is_stale && folder.is_up_to_date(without_removed(folder, entry), key)) return {};
  if (entry.status == "not run") return "it was not run";
  if (entry.status == "failed") return "it failed";
  if (entry.status == "interrupted") return "it was interrupted";
  if (entry.is_stale || entry.key != key)
    return "its settings, its files or the program have changed";
  return "its files are missing or changed";
}

}  // namespace

bool is_dicom(const std::string& input) {
  if (input.empty() || input_kind(input) != InputKind::volume) return false;
  return !segmentation::is_volume_file(input);
}

bool applies(const StageDefinition& stage, const RunRecord& record) {
  return stage.input_kind.empty() || stage.input_kind == record.input_kind;
}

RunRequest with_file_of_folder(RunRequest request) {
  request.input = file_or_dicom(request.input, request.config.input);
  return request;
}

RunRecord describe_input(const RunRequest& given, const CaseFolder& folder) {
  const RunRequest request = with_file_of_folder(given);
  if (request.input.empty()) {
    if (!folder.exists("run.json"))
      throw InputError(
          fmt::format("{} is no case (it has no run.json). Begin with `angio run INPUT "
                      "-o {}`",
                      folder.root().string(), folder.root().string()),
          ExitCode::no_input);
    return folder.read_record();
  }
  RunRecord record;
  const InputKind kind = input_kind(request.input);
  if (kind == InputKind::phantom && request.config.surface_unit)
    throw Error(ExitCode::usage, "--unit belongs to files; a phantom is in mm");
  const bool is_exact = kind == InputKind::phantom && !request.config.experiment.empty();
  record.input_kind = name(is_exact                ? InputKind::surface
                           : is_run(request, kind) ? InputKind::run
                                                   : kind);
  record.input_sha256 =
      kind == InputKind::phantom ? sha256_of_text(request.input) : sha256_of_path(request.input);
  if (!request.geometry.empty())  // it is as much of the input as the frames are
    record.input_sha256 = sha256_of_text(record.input_sha256 + sha256_of_path(request.geometry));
  record.case_name =
      request.case_name.empty() ? record.input_sha256.substr(0, 12) : printable(request.case_name);
  return record;
}

CaseProgress case_progress(const Workflow& workflow, const RunRequest& request) {
  using State = CaseProgress::State;
  const CaseFolder folder(request.case_folder);
  if (!folder.exists("run.json")) {
    return {is_free(folder) ? State::not_begun : State::of_another, ""};
  }
  const RunRecord wanted = describe_input(request, folder);
  RunRecord record = folder.read_record();
  if (record.input_sha256 != wanted.input_sha256) return {State::of_another, ""};
  if (record.input_kind != wanted.input_kind) return {State::begun, "its input is taken otherwise"};
  if (record.case_name != wanted.case_name) return {State::begun, "its name has changed"};
  for (const StageDefinition& stage : workflow.stages) {
    if (!stage.work || stage.stage > request.until || !applies(stage, record)) continue;
    const std::string reason = why_again(stage, request.config, record, folder);
    if (!reason.empty()) return {State::begun, fmt::format("from {}: {}", stage.name, reason)};
  }
  for (const auto& [name, hash] : record.files)
    if (!fs::is_regular_file(folder.path(name)) || sha256_of_path(folder.path(name)) != hash)
      return {State::begun, fmt::format("{} is missing or changed", name)};
  if (request.keep == Keep::minimal && !bulky_files(folder, record).empty())
    return {State::begun, "its bulky files are to be removed"};
  return {State::done, "", is_minimal(record)};
}

}  // namespace angio::pipeline
