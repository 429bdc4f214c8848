#include "pipeline/cli/bids_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/version.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr const char* kParticipant = "sub-";
constexpr const char* kSession = "ses-";

/// The entries of a folder whose names begin with `prefix`, by name.
std::vector<fs::path> entries_of(const fs::path& folder, const std::string& prefix) {
  std::vector<fs::path> found;
  std::error_code error;
  auto entry = fs::directory_iterator(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error))
    if (entry->path().filename().string().starts_with(prefix)) found.push_back(entry->path());
  std::sort(found.begin(), found.end());
  return found;
}

/// The scans in the data types' folders (anat, ...) of a participant or a session.
void add_scans(const fs::path& folder, const std::string& suffix, std::vector<BatchCase>& cases) {
  for (const fs::path& type : entries_of(folder, ""))
    for (const fs::path& file : entries_of(type, kParticipant))
      for (const char* ending : {".nii", ".nii.gz"}) {
        const std::string end = "_" + suffix + ending;
        const std::string name = file.filename().string();
        if (!name.ends_with(end)) continue;
        BatchCase one;
        one.name = name.substr(0, name.size() - end.size());
        one.input = one.input_cell = file.string();
        cases.push_back(one);
      }
}

std::set<std::string> wanted_labels(const std::vector<std::string>& labels) {
  std::set<std::string> wanted;
  for (const std::string& label : labels)
    wanted.insert(label.starts_with(kParticipant) ? label : kParticipant + label);
  return wanted;
}

/// What makes a folder of results a dataset of its own (BIDS 1.8, derivatives).
void describe_dataset(const fs::path& folder) {
  const nlohmann::json description = {
      {"Name", "angio: lumen, centreline, meshes and balloon angioplasty"},
      {"BIDSVersion", "1.8.0"},
      {"DatasetType", "derivative"},
      {"GeneratedBy", {{{"Name", "angio"}, {"Version", kVersion}}}}};
  write_text_atomically(folder / "dataset_description.json", description.dump(2) + "\n");
}

}  // namespace

std::vector<BatchCase> bids_cases(const fs::path& dataset, const std::string& suffix,
                                  const std::vector<std::string>& labels) {
  if (!fs::is_directory(dataset))
    throw InputError(
        fmt::format("there is no folder {} (of a BIDS dataset). Check the path", dataset.string()),
        ExitCode::no_input);
  const std::set<std::string> wanted = wanted_labels(labels);
  std::set<std::string> missing = wanted;
  std::vector<BatchCase> cases;
  for (const fs::path& participant : entries_of(dataset, kParticipant)) {
    const std::string label = participant.filename().string();
    if (!wanted.empty() && !wanted.contains(label)) continue;
    missing.erase(label);
    add_scans(participant, suffix, cases);
    for (const fs::path& session : entries_of(participant, kSession))
      add_scans(session, suffix, cases);
  }
  if (!missing.empty())
    throw InputError(fmt::format("there is no participant {} in the dataset. Check "
                                 "--participant-label",
                                 *missing.begin()),
                     ExitCode::no_input);
  if (cases.empty())
    throw InputError(fmt::format("the dataset holds no sub-*/[ses-*/]*/*_{}.nii[.gz] (other scans "
                                 "are named by --suffix)",
                                 suffix),
                     ExitCode::no_input);
  return cases;
}

void add_bids_command(CLI::App& app, BidsArguments& bids) {
  CLI::App& command = *app.add_subcommand(
      "bids",
      "a BIDS dataset as a batch, in the words of a BIDS App\n"
      "participant: a case for every scan sub-*/[ses-*/]*/*_angio.nii[.gz]; group: their summary");
  command.add_option("BIDS_DIR", bids.dataset, "the dataset")->required();
  command.add_option("OUTPUT_DIR", bids.request.folder, "gets a case folder a scan, as a batch's")
      ->required();
  command.add_option("LEVEL", bids.level, "participant or group")
      ->required()
      ->check(CLI::IsMember({"participant", "group"}));
  command
      .add_option("--participant-label,--participant_label", bids.labels,
                  "these participants alone, with or without sub-")
      ->type_name("LABEL");
  command.add_option("--suffix", bids.suffix, "of the scans' file names")->capture_default_str();
  command.add_option("-j,--jobs,--n_cpus", bids.request.jobs, "cases at a time, 1 to 256")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command.add_flag("--skip-bids-validator,--skip_bids_validator", bids.no_validator,
                   "taken and not needed: nothing but the names is looked at");
  add_keep_option(command, bids.keep);
  add_run_options(command, bids.shared);
}

int do_bids(BidsArguments& bids) {
  BatchRequest& request = bids.request;
  apply_options(request.config, bids.shared);
  request.config.validate();
  request.config = {};
  request.shared = bids.shared;
  request.threads = bids.shared.threads;
  request.keep = keep_of(bids.keep);
  request.arguments = {"--quiet"};
  request.resume = true;
  request.program = fs::read_symlink("/proc/self/exe");
  const std::vector<BatchCase> cases = bids_cases(bids.dataset, bids.suffix, bids.labels);
  Reporter reporter(bids.shared.style());
  int failed = 0;
  if (bids.level == "group") {
    if (!fs::is_directory(request.folder))
      throw InputError(fmt::format("there is no {} to sum up. Begin with the level participant",
                                   request.folder.string()),
                       ExitCode::no_input);
    failed = summarize_batch(request, cases);
  } else {
    make_folder(request.folder);
    describe_dataset(request.folder);
    failed = run_batch(request, cases, reporter).failed;
  }
  reporter.result(summary_file(request).string());
  return int(failed > 0 ? ExitCode::some_cases_failed : ExitCode::done);
}

}  // namespace angio::pipeline
