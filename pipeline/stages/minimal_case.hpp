#pragma once

#include <map>
#include <string>
#include <vector>

#include "pipeline/case/case_folder.hpp"

/// A case whose bulky files were removed once it was done (`--keep minimal`). run.json keeps their
/// hashes and says that they were removed, so that the case still counts as done.
namespace angio::pipeline {

/// Which files of a case that is done stay.
enum class Keep {
  all,
  minimal,  ///< run.json, metrics.json, case.toml, and the files of is_kept()
};

/// Does a file stay: report, lines, lesions, placement, tables and summary of the simulation?
bool is_kept(const std::string& file);

/// Has any of the case's files been removed?
bool is_minimal(const RunRecord& record);

/// Files of the case that are there, but would not stay.
std::vector<std::string> bulky_files(const CaseFolder& case_folder, const RunRecord& record);

/// Writes down what will be removed, then removes it: killed in between, the next call goes on.
void remove_bulky_files(const CaseFolder& case_folder);

/// As CaseFolder::hashes, with the recorded hashes of files that were removed.
std::map<std::string, std::string> hashes_as_left(const CaseFolder& case_folder,
                                                  const RunRecord& record,
                                                  const std::vector<std::string>& declared);

/// The stage without what was removed of its outputs.
StageRecord without_removed(const CaseFolder& case_folder, const StageRecord& stage);

}  // namespace angio::pipeline
