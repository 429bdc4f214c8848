#include "pipeline/stages/run_case.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <future>
#include <iterator>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/printable.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/case_status.hpp"
#include "pipeline/case/hidden_input.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/running_case.hpp"
#include "pipeline/stages/case_progress.hpp"
#include "pipeline/stages/require_backend.hpp"
#include "pipeline/stages/stage_keys.hpp"
#include "pipeline/stages/stage_work.hpp"
#include "pipeline/version.hpp"
#include "segmentation/dicom_segmentation.hpp"
#include "segmentation/read_volume.hpp"
#include "simulation/wake_gpu.hpp"

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
      : folder_(folder), existed_(fs::exists(folder.root())), undo_(is_free(folder)) {}
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

void write_private_link(const CaseFolder& folder, const RunRequest& request) {
  const std::string source =
      request.source.empty() ? fs::absolute(request.input).string() : request.source;
  const mode_t former = umask(0077);
  write_text_atomically(folder.path("source.private.json"),
                        nlohmann::json{{"input", source}}.dump(2) + "\n");
  umask(former);
}

/// The record to go on from: what the case already has, if its input is the same.
RunRecord take_up(const RunRequest& request, const CaseFolder& folder) {
  RunRecord wanted = describe_input(request, folder);
  folder.claim(wanted, request.force);
  if (request.force) return wanted;
  RunRecord record = folder.read_record();
  if (record.input_sha256 != wanted.input_sha256) return wanted;
  if (!request.case_name.empty()) record.case_name = printable(request.case_name);
  record.input_kind = wanted.input_kind;  // the settings say how INPUT is taken
  return record;
}

std::map<std::string, std::string> gather_inputs(const StageDefinition& stage,
                                                 const CaseFolder& folder) {
  auto inputs = folder.hashes(stage.inputs);
  if (inputs.empty() && !stage.inputs.empty() && stage.own_inputs.empty())
    throw InputError(fmt::format("{} has nothing for the stage {} to work on. Run the stages "
                                 "before it: `angio run INPUT -o {}`",
                                 folder.root().string(), stage.name, folder.root().string()),
                     ExitCode::no_input);
  return inputs;
}

/// One run through the stages of a case.
class Run {
 public:
  Run(const Workflow& workflow, const RunRequest& request, const CaseFolder& folder,
      RunRecord record, Reporter& reporter)
      : workflow_(workflow),
        request_(request),
        folder_(folder),
        record_(std::move(record)),
        reporter_(reporter) {}

  /// Takes the numbers that are stale out of the case before anything else is done.
  void begin();
  void run_stage(const StageDefinition& stage, bool forced);
  [[nodiscard]] bool is_for(const StageDefinition& stage) const { return applies(stage, record_); }
  [[nodiscard]] bool is_of_projections() const {
    return record_.input_kind == name(InputKind::run);
  }
  [[nodiscard]] bool has_failed(Stage stage) const { return record_.is(stage, "failed"); }
  /// Brings run.json, metrics.json and the report's notice up to what the stages have left.
  void settle();
  /// The same where something has failed already.
  void settle_quietly();
  void end() {
    if (!is_settled_) settle();
  }

 private:
  void make(const StageDefinition& stage, const std::map<std::string, std::string>& inputs);
  void work(const StageDefinition& stage, StageRecord& entry);
  void skip(const StageDefinition& stage, const std::map<std::string, std::string>& inputs);
  void write_metrics(const RunRecord& record) const;
  void forget_backend(const StageDefinition& stage) {
    if (stage.stage == Stage::simulation) record_.backend = record_.device = "";
  }
  [[nodiscard]] std::string key_of(const StageDefinition& stage,
                                   const std::map<std::string, std::string>& inputs) const {
    return stage_key(stage, request_.config, record_, inputs);
  }

  const Workflow& workflow_;
  const RunRequest& request_;
  const CaseFolder& folder_;
  RunRecord record_;
  Reporter& reporter_;
  bool is_settled_ = false;
  std::future<void> gpu_;  ///< wakes beside the meshing
};

/// Does the work, puts the stage's folder in place, and takes over what the stage has to say.
void Run::work(const StageDefinition& stage, StageRecord& entry) {
  std::vector<std::string> declared = stage.inputs;
  if (request_.input.empty())
    declared.insert(declared.end(), stage.own_inputs.begin(), stage.own_inputs.end());
  const StageFiles files(folder_, declared);
  const RunRecord seen = stage.sees(request_.config, record_);
  StageFolder output(folder_, stage.stage);
  StageWork work{
      files, seen, request_.input, request_.geometry, output.path(), reporter_.progress()};
  stage.work(work, request_.config);
  throw_if_interrupted();
  output.commit();
  if (!work.input_description.empty()) record_.input_description = work.input_description;
  if (!work.backend.empty()) {
    record_.backend = work.backend;
    record_.device = work.device;
  }
  entry.solver_seconds = work.solver_seconds;
  entry.time_split = work.time_split;
  for (const std::string& warning : work.warnings)
    entry.warnings.push_back(without_input(warning, request_.input));
  entry.outputs = folder_.hashes(stage.stage);
  if (!work.failure.empty()) throw InputError(work.failure);
  const bool is_given =
      stage.stage == Stage::segmentation && record_.input_kind == name(InputKind::surface);
  entry.status = work.is_given_up ? "skipped" : is_given ? "given" : "done";
}

void Run::make(const StageDefinition& stage, const std::map<std::string, std::string>& inputs) {
  const auto start = std::chrono::steady_clock::now();
  const PeakMemory memory;
  StageRecord& entry = record_.stages[stage.stage] = {};
  entry.inputs = inputs;
  entry.status = "failed";
  forget_backend(stage);
  const bool leads_to_gpu = stage.stage == Stage::simulation ||
                            (stage.stage == Stage::meshing && request_.until >= Stage::simulation);
  if (leads_to_gpu && !gpu_.valid())
    gpu_ = simulation::wake_gpu(request_.config.simulation.backend);
  const auto end = [&] {
    entry.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    entry.key = key_of(stage, inputs);
    entry.build = version_with_commit();
  };
  try {
    work(stage, entry);
  } catch (const nlohmann::json::exception&) {
    end();
    throw InputError(
        fmt::format("the case's files do not fit this version for the stage {} (they "
                    "are damaged, or another version wrote them). Add --force to "
                    "`angio run`",
                    stage.name));
  } catch (const Error& error) {
    end();
    if (error.exit_code() == ExitCode::interrupted) entry.status = "interrupted";
    entry.warnings.insert(entry.warnings.begin(), without_input(error.what(), request_.input));
    throw;
  } catch (...) {
    end();
    throw;
  }
  entry.peak_memory_mib = memory.mebibytes();
  end();
}

/// There is nothing to simulate: what lies there is of another state of the case.
void Run::skip(const StageDefinition& stage, const std::map<std::string, std::string>& inputs) {
  fs::remove_all(folder_.folder(stage.stage));
  forget_backend(stage);
  record_.stages[stage.stage] = {};
  record_.stages[stage.stage].status = "skipped";
  record_.stages[stage.stage].key = key_of(stage, inputs);
  record_.stages[stage.stage].build = version_with_commit();
}

void Run::run_stage(const StageDefinition& stage, bool forced) {
  reporter_.begin_stage(stage.name);
  StageRecord& entry = record_.stages[stage.stage];
  if (!stage.work) {
    entry.status = "skipped";
    return reporter_.end_stage(stage.name, "skipped", 0.0);
  }
  const auto inputs = gather_inputs(stage, folder_);
  if (stage.stage == Stage::simulation && is_untreated(folder_)) {
    skip(stage, inputs);
    settle();
    return reporter_.end_stage(stage.name, "skipped", 0.0);
  }
  if (stage.stage == Stage::report) mark_report(folder_, false);  // its content counts
  if (!forced && folder_.is_up_to_date(entry, key_of(stage, inputs))) {
    entry.is_stale = false;
    is_settled_ = false;
    return reporter_.end_stage(stage.name, "up to date", 0.0);
  }
  if (stage.stage == Stage::report) mark_report(folder_, true);
  make(stage, inputs);
  settle();
  for (const std::string& warning : entry.warnings) reporter_.warn(stage.name, warning);
  reporter_.end_stage(stage.name, entry.status, entry.seconds);
}

void Run::write_metrics(const RunRecord& record) const {
  const StageFiles files(folder_, workflow_.metrics_files);
  const nlohmann::json metrics = workflow_.metrics(files, request_.config, record);
  write_text_atomically(folder_.path("metrics.json"), metrics.dump(2) + "\n");
}

void Run::begin() {
  record_.files.clear();
  mark_stale(folder_, workflow_, request_.config, record_);
  folder_.write_record(record_);
  if (std::none_of(record_.stages.begin(), record_.stages.end(),
                   [](const auto& entry) { return entry.second.is_stale; }))
    return;
  RunRecord nothing_found = record_;
  nothing_found.stages.erase(Stage::centerline);
  write_metrics(nothing_found);
  mark_report(folder_, true);
}

void Run::settle() {
  record_.files.clear();
  mark_stale(folder_, workflow_, request_.config, record_);
  folder_.write_record(record_);  // first: what metrics.json lacks run.json must not tell
  write_metrics(record_);
  record_.files = folder_.hashes({formats::case_file::kSettings, formats::case_file::kMetrics});
  folder_.write_record(record_);
  mark_report(folder_, !record_.is(Stage::report, "done"));
  is_settled_ = true;
}

void Run::settle_quietly() {
  try {
    settle();
  } catch (const std::exception&) {  // what happened first is what is reported
  }
}

void run_stages(const Workflow& workflow, const RunRequest& request, const CaseFolder& folder,
                Run& run, NewCase& new_case) {
  if (request.until == Stage::reconstruction && !run.is_of_projections())
    throw InputError(
        "there is nothing to reconstruct: the input is no rotational run that can be used. `angio "
        "inspect` says what it is");
  const int first = request.input.empty() ? int(request.from.value_or(Stage::reconstruction)) : 0;
  for (const StageDefinition& stage : workflow.stages) {
    if (int(stage.stage) < first || stage.stage > request.until || !run.is_for(stage)) continue;
    try {
      run.run_stage(stage, request.force || (request.from && stage.stage >= *request.from));
    } catch (const InputError&) {
      // Of a simulation that fails the report says so, if it is asked for, before the failure
      // goes on.
      const bool is_told = stage.stage == Stage::simulation && run.has_failed(stage.stage) &&
                           workflow.stages.back().tells_of_failure;
      run.settle_quietly();
      if (is_told && request.until == Stage::report) run.run_stage(workflow.stages.back(), true);
      throw;
    }
    new_case.keep();
    if (stage.stage == Stage::segmentation && request.keep_link && !run.is_of_projections() &&
        is_dicom(request.input))
      segmentation::write_dicom_segmentation(
          folder.path("segmentation.private.dcm"),
          segmentation::read_volume_file(folder.path("segmentation/lumen_level_set.nrrd")),
          request.input, request.config.input);
  }
}

/// Whether the simulation is among the stages that a request may run.
bool may_simulate(const RunRequest& request) {
  return request.until >= Stage::simulation &&
         (!request.input.empty() || request.from.value_or(Stage::simulation) <= Stage::simulation);
}

/// Is a case done whose bulky files were removed, and are not asked for? Otherwise they are made
/// again.
bool is_done_minimal(const Workflow& workflow, RunRequest request) {
  if (!is_minimal(CaseFolder(request.case_folder).read_record())) return false;
  if (request.input.empty())
    throw InputError(
        fmt::format("the stages' files of {0} were removed (--keep minimal; nothing is left to go "
                    "on from). Name its input again: `angio run INPUT -o {0}`",
                    request.case_folder.string()),
        ExitCode::no_input);
  if (request.keep == Keep::all || request.force || request.from || request.keep_link) return false;
  request.keep = Keep::all;
  return case_progress(workflow, request).state == CaseProgress::State::done;
}

}  // namespace

fs::path run_case(const Workflow& workflow, const RunRequest& given, Reporter& reporter) {
  given.config.validate();
  const RunRequest request = with_file_of_folder(given);
  if (may_simulate(request)) require_backend(request.config.simulation.backend);
  const CaseFolder folder(request.case_folder);
  NewCase new_case(folder);
  RunRecord record = take_up(request, folder);
  const CaseLock lock(folder);
  const LockNote note(folder);
  remove_leftovers(folder);
  const bool is_thinned = request.keep == Keep::minimal && request.until == Stage::report;
  if (is_done_minimal(workflow, request)) {
    remove_bulky_files(folder);
    reporter.note("up to date; the stages' files were removed (--keep minimal)");
    return folder.path("report/index.html");
  }
  Run run(workflow, request, folder, std::move(record), reporter);
  run.begin();  // run.json comes first: a folder without it is no case, and would be refused
  write_text_atomically(folder.path("case.toml"), to_toml(request.config));
  if (request.keep_link && !request.input.empty()) write_private_link(folder, request);
  try {
    run_stages(workflow, request, folder, run, new_case);
  } catch (...) {
    run.settle_quietly();
    throw;
  }
  run.end();
  if (is_thinned) remove_bulky_files(folder);
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
