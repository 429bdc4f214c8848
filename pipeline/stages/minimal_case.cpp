#include "pipeline/stages/minimal_case.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "formats/case_file.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace file = formats::case_file;
namespace {

/// Its file was removed, and has not come back.
bool is_removed(const CaseFolder& case_folder, const StageRecord& stage, const std::string& name) {
  return std::find(stage.removed.begin(), stage.removed.end(), name) != stage.removed.end() &&
         !case_folder.exists(name);
}

/// Does a name of run.json stand for a file inside the case, also past links?
bool is_inside(const CaseFolder& case_folder, const std::string& name) {
  const fs::path root = fs::weakly_canonical(case_folder.root());
  const fs::path path = fs::weakly_canonical(case_folder.path(name));
  return std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first == root.end();
}

void remove_empty_folders(const CaseFolder& case_folder) {
  std::vector<fs::path> folders;
  for (int s = 0; s < kStageCount; ++s) {
    const fs::path root = case_folder.folder(Stage(s));
    if (!fs::is_directory(root)) continue;
    folders.push_back(root);
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root))
      if (entry.is_directory()) folders.push_back(entry.path());
  }
  std::error_code is_not_empty;
  std::for_each(folders.rbegin(), folders.rend(),
                [&](const fs::path& folder) { fs::remove(folder, is_not_empty); });
}

}  // namespace

bool is_kept(const std::string& name) {
  static const std::vector<std::string> kKept = {
      "report/",        file::kCenterlines,    "centerline/paths.vtp", file::kLesions,
      file::kPlacement, file::kTimeSeries,     file::kProfile,         file::kSummary,
      file::kDiagnosis, "simulation/cloth.csv"};
  return names_file(kKept, name);
}

bool is_minimal(const RunRecord& record) {
  return std::any_of(record.stages.begin(), record.stages.end(),
                     [](const auto& stage) { return !stage.second.removed.empty(); });
}

std::vector<std::string> bulky_files(const CaseFolder& case_folder, const RunRecord& record) {
  std::vector<std::string> files;
  for (const auto& [stage, entry] : record.stages)
    for (const auto& [name, hash] : entry.outputs)
      if (!is_kept(name) && case_folder.exists(name) && is_inside(case_folder, name))
        files.push_back(name);
  return files;
}

void remove_bulky_files(const CaseFolder& case_folder) {
  RunRecord record = case_folder.read_record();
  const std::vector<std::string> bulky = bulky_files(case_folder, record);
  for (auto& [stage, entry] : record.stages) {
    entry.removed.clear();
    for (const auto& [name, hash] : entry.outputs)
      if (!is_kept(name)) entry.removed.push_back(name);
  }
  case_folder.write_record(record);
  for (const std::string& name : bulky) fs::remove(case_folder.path(name));
  remove_empty_folders(case_folder);
}

std::map<std::string, std::string> hashes_as_left(const CaseFolder& case_folder,
                                                  const RunRecord& record,
                                                  const std::vector<std::string>& declared) {
  std::map<std::string, std::string> hashes = case_folder.hashes(declared);
  for (const auto& [stage, entry] : record.stages)
    for (const std::string& name : entry.removed)
      if (names_file(declared, name) && is_removed(case_folder, entry, name))
        hashes[name] = entry.outputs.at(name);
  return hashes;
}

StageRecord without_removed(const CaseFolder& case_folder, const StageRecord& stage) {
  StageRecord left = stage;
  std::erase_if(left.outputs,
                [&](const auto& output) { return is_removed(case_folder, stage, output.first); });
  return left;
}

}  // namespace angio::pipeline
