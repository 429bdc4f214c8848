#include "pipeline/stages.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/case_status.hpp"
#include "pipeline/experiment.hpp"
#include "pipeline/metrics.hpp"
#include "pipeline/stage_work.hpp"
#include "pipeline/version.hpp"
#include "segmentation/dicom_segmentation.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

/// Peak resident memory since construction, by Linux's resettable high-water mark (proc(5)).
class PeakMemory {
 public:
  PeakMemory() {
    malloc_trim(0);  // what the former stage has freed is not this one's
    std::ofstream("/proc/self/clear_refs") << "5";
  }
  [[nodiscard]] static double mebibytes() {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
      if (word == "VmHWM:") {
        double kibibytes = 0.0;
        status >> kibibytes;
        return kibibytes / 1024.0;
      }
    return 0.0;
  }
};

/// Takes back a case that this run began if not even its first stage succeeds.
class NewCase {
 public:
  explicit NewCase(const CaseFolder& folder)
      : folder_(folder),
        existed_(fs::exists(folder.root())),
        undo_(!existed_ || (fs::is_directory(folder.root()) && fs::is_empty(folder.root()))) {}
  ~NewCase() {
    if (!undo_) return;
    std::error_code ignored;
    for (const char* file : {"case.toml", "run.json", "metrics.json", "source.private.json"})
      fs::remove(folder_.path(file), ignored);
    if (!existed_) fs::remove(folder_.root(), ignored);
  }
  NewCase(const NewCase&) = delete;
  NewCase& operator=(const NewCase&) = delete;
  void keep() { undo_ = false; }

 private:
  const CaseFolder& folder_;
  bool existed_;
  bool undo_;
};

void write_private_link(const CaseFolder& folder, const std::string& input) {
  const mode_t former = umask(0077);
  write_text_atomically(folder.path("source.private.json"),
                        nlohmann::json{{"input", fs::absolute(input).string()}}.dump(2) + "\n");
  umask(former);
}

bool is_dicom(const std::string& input) {
  if (input.empty() || input_kind(input) != InputKind::volume) return false;
  constexpr const char* kVolumeFiles[] = {".nrrd", ".nhdr", ".mha", ".mhd", ".nii", ".gz", ".vti"};
  const std::string extension = fs::path(input).extension().string();
  return fs::is_directory(input) || std::find(std::begin(kVolumeFiles), std::end(kVolumeFiles),
                                              extension) == std::end(kVolumeFiles);
}

RunRecord describe_input(const RunRequest& request, const CaseFolder& folder) {
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
  const bool is_exact = kind == InputKind::phantom && !request.config.experiment.empty();
  record.input_kind = name(is_exact ? InputKind::surface : kind);
  record.input_sha256 =
      kind == InputKind::phantom ? sha256_of_text(request.input) : sha256_of_path(request.input);
  record.case_name =
      request.case_name.empty() ? record.input_sha256.substr(0, 12) : request.case_name;
  return record;
}

/// The record to go on from: what the case already has, if its input is the same.
RunRecord take_up(const RunRequest& request, const CaseFolder& folder) {
  RunRecord wanted = describe_input(request, folder);
  folder.claim(wanted, request.force);
  if (request.force) return wanted;
  RunRecord record = folder.read_record();
  if (record.input_sha256 != wanted.input_sha256) return wanted;
  if (!request.case_name.empty()) record.case_name = request.case_name;
  return record;
}

std::string stage_key(Stage stage, const RunRequest& request, const RunRecord& record,
                      const std::map<std::string, std::string>& inputs) {
  std::string text =
      fmt::format("{}\n{}\n{}", kVersion, name(stage), stage_settings(request.config, stage));
  if (stage == first_stage(request.config)) text += record.input_sha256;
  if (stage == Stage::report) {
    text += record.case_name;
    const auto simulated = record.stages.find(Stage::simulation);
    if (simulated != record.stages.end()) text += "\nsimulation " + simulated->second.status;
  }
  for (const auto& [file, hash] : inputs) text += file + " " + hash + "\n";
  return sha256_of_text(text);
}

std::map<std::string, std::string> gather_inputs(Stage stage, const Config& config,
                                                 const CaseFolder& folder) {
  auto inputs = folder.hashes(stage_inputs(stage));
  if (inputs.empty() && stage != first_stage(config))
    throw InputError(fmt::format("{} has nothing for the stage {} to work on. Run the stages "
                                 "before it: `angio run INPUT -o {}`",
                                 folder.root().string(), name(stage), folder.root().string()),
                     ExitCode::no_input);
  return inputs;
}

std::map<std::string, std::string> hash_outputs(const CaseFolder& folder, Stage stage) {
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder.folder(stage)))
    if (entry.is_regular_file())
      files.push_back(fs::relative(entry.path(), folder.root()).string());
  return folder.hashes(files);
}

/// Does the work of one stage and puts its folder in place.
void make_stage(Stage stage, const RunRequest& request, const CaseFolder& folder,
                const std::string& key, RunRecord& record, Reporter& reporter) {
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const PeakMemory memory;
  StageRecord& entry = record.stages[stage] = {};
  entry.inputs = folder.hashes(stage_inputs(stage));
  try {
    StageFolder output(folder, stage);
    StageWork work{
        folder, request.config, output.path(), reporter.progress(), request.input, record, {}, {}};
    do_stage(stage, work);
    throw_if_interrupted();
    output.commit();
    entry.warnings = work.warnings;
    if (!work.failure.empty()) throw InputError(work.failure);
  } catch (const nlohmann::json::exception&) {
    entry.status = "failed";
    folder.write_record(record);
    throw InputError(
        fmt::format("the case's files do not fit this version for the stage {} (they "
                    "are damaged, or another version wrote them). Add --force to "
                    "`angio run`",
                    name(stage)));
  } catch (const Error& error) {
    entry.status = error.exit_code() == ExitCode::interrupted ? "interrupted" : "failed";
    entry.warnings.insert(entry.warnings.begin(), error.what());
    entry.seconds = seconds();
    folder.write_record(record);
    throw;
  } catch (...) {
    entry.status = "failed";
    entry.seconds = seconds();
    folder.write_record(record);
    throw;
  }
  const bool given = stage == Stage::segmentation && record.input_kind == name(InputKind::surface);
  entry.status = given ? "given" : "done";
  entry.key = key;
  entry.outputs = hash_outputs(folder, stage);
  entry.peak_memory_mib = memory.mebibytes();
  entry.seconds = seconds();
}

void write_metrics(const RunRequest& request, const CaseFolder& folder, const RunRecord& record) {
  write_text_atomically(folder.path("metrics.json"),
                        collect_metrics(folder, request.config, record).dump(2) + "\n");
}

void run_stage(Stage stage, const RunRequest& request, bool forced, const CaseFolder& folder,
               RunRecord& record, Reporter& reporter) {
  reporter.begin_stage(name(stage));
  if (is_skipped(stage, request.config)) {
    record.stages[stage].status = "skipped";
    folder.write_record(record);
    reporter.end_stage(name(stage), "skipped", 0.0);
    return;
  }
  if (stage == Stage::simulation && is_untreated(folder)) {
    fs::remove_all(folder.folder(stage));  // of another state of the case
    record.stages[stage] = {};
    record.stages[stage].status = "skipped";
    folder.write_record(record);
    write_metrics(request, folder, record);
    reporter.end_stage(name(stage), "skipped", 0.0);
    return;
  }
  const auto inputs = gather_inputs(stage, request.config, folder);
  const std::string key = stage_key(stage, request, record, inputs);
  if (!forced && folder.is_up_to_date(record.stages[stage], key)) {
    reporter.end_stage(name(stage), "up to date", 0.0);
    return;
  }
  make_stage(stage, request, folder, key, record, reporter);
  folder.write_record(record);
  write_metrics(request, folder, record);
  const StageRecord& entry = record.stages[stage];
  for (const std::string& warning : entry.warnings) reporter.warn(name(stage), warning);
  reporter.end_stage(name(stage), entry.status, entry.seconds);
}

/// Runs a stage. Of a simulation that fails the case and, if it is asked for, the report tell
/// before the failure goes on.
void run_or_tell(Stage stage, const RunRequest& request, bool forced, const CaseFolder& folder,
                 RunRecord& record, Reporter& reporter) {
  try {
    run_stage(stage, request, forced, folder, record, reporter);
  } catch (const InputError&) {
    if (stage != Stage::simulation || record.stages[stage].status != "failed" ||
        is_cloth(request.config))
      throw;
    write_metrics(request, folder, record);
    if (request.until == Stage::report)
      run_stage(Stage::report, request, true, folder, record, reporter);
    throw;
  }
}

}  // namespace

fs::path run_case(const RunRequest& request, Reporter& reporter) {
  request.config.validate();
  const CaseFolder folder(request.case_folder);
  NewCase new_case(folder);
  RunRecord record = take_up(request, folder);
  const CaseLock lock(folder);
  write_text_atomically(folder.path("case.toml"), to_toml(request.config));
  if (request.keep_link && !request.input.empty()) write_private_link(folder, request.input);
  folder.write_record(record);

  const int first = request.input.empty() ? int(request.from.value_or(Stage::segmentation)) : 0;
  for (int s = first; s <= int(request.until); ++s) {
    const bool forced = request.force || (request.from && s >= int(*request.from));
    run_or_tell(Stage(s), request, forced, folder, record, reporter);
    new_case.keep();
    if (Stage(s) == Stage::segmentation && request.keep_link && is_dicom(request.input))
      segmentation::write_dicom_segmentation(
          folder.path("segmentation.private.dcm"),
          segmentation::read_volume_file(folder.path("segmentation/lumen_level_set.nrrd")),
          request.input, request.config.input);
  }
  return request.until == Stage::report ? folder.path("report/index.html")
                                        : folder.folder(request.until);
}

Config case_config(const CaseFolder& case_folder) {
  if (!case_folder.exists("case.toml"))
    throw InputError(fmt::format("{} is no case (it has no case.toml). Begin with `angio run INPUT "
                                 "-o {}`",
                                 case_folder.root().string(), case_folder.root().string()),
                     ExitCode::no_input);
  Config config;
  load_config(config, case_folder.path("case.toml"));
  return config;
}

}  // namespace angio::pipeline
