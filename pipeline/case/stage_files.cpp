#include "pipeline/case/stage_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.hpp"

namespace angio::pipeline {

bool names_file(const std::string& declared, const std::string& file) {
  return file == declared || (declared.ends_with('/') && file.starts_with(declared));
}

bool names_file(const std::vector<std::string>& declared, const std::string& file) {
  return std::any_of(declared.begin(), declared.end(),
                     [&](const std::string& entry) { return names_file(entry, file); });
}

StageFiles::StageFiles(const CaseFolder& case_folder, std::vector<std::string> declared)
    : case_folder_(case_folder), declared_(std::move(declared)) {}

std::filesystem::path StageFiles::path(const std::string& file) const {
  if (!names_file(declared_, file))
    throw InternalError(fmt::format("{} is read and is not among the stage's inputs", file));
  opened_.insert(file);
  return case_folder_.path(file);
}

bool StageFiles::exists(const std::string& file) const {
  return std::filesystem::exists(path(file));
}

}  // namespace angio::pipeline
