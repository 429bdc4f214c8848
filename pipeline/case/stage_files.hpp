#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "pipeline/case/case_folder.hpp"

namespace angio::pipeline {

/// Does a name stand for a file: is it the file's own, or, with a '/' at its end, that of a folder
/// around it?
bool names_file(const std::string& declared, const std::string& file);
bool names_file(const std::vector<std::string>& declared, const std::string& file);

/// The case's files that may be opened: those that were declared, whose content is in the key of
/// the stage that opens them.
class StageFiles {
 public:
  /// @param declared  files in the case, or folders with a '/' at the end
  StageFiles(const CaseFolder& case_folder, std::vector<std::string> declared);

  /// Where a file lies. A folder that is declared may be named, too.
  /// @throws InternalError if it is not declared
  [[nodiscard]] std::filesystem::path path(const std::string& file) const;
  [[nodiscard]] bool exists(const std::string& file) const;

  /// What has been asked for so far.
  [[nodiscard]] const std::set<std::string>& opened() const { return opened_; }

 private:
  CaseFolder case_folder_;
  std::vector<std::string> declared_;
  mutable std::set<std::string> opened_;
};

}  // namespace angio::pipeline
