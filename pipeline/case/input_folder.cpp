#include "pipeline/case/input_folder.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "core/error.hpp"
#include "core/text.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

bool is_case(const fs::path& folder) {
  return fs::exists(folder / formats::case_file::kRun) && fs::exists(folder / "case.toml");
}

bool is_volume_or_surface(const fs::path& file) {
  return segmentation::is_volume_file(file) || formats::is_surface_ending(lower_extension(file));
}

}  // namespace

std::vector<std::string> files_instead_of_dicom(const std::string& input,
                                                const segmentation::ReadOptions& options) {
  std::error_code ignored;
  if (!fs::is_directory(input, ignored)) return {};
  if (is_case(input))
    throw InputError(
        fmt::format("{0} is a case of angio, no input. `angio view {0}` shows it, "
                    "`angio verify {0}` checks it, `angio run -o {0}` goes on with it",
                    input));
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(input, ignored))
    if (entry.is_regular_file(ignored) && is_volume_or_surface(entry.path()))
      files.push_back(entry.path().string());
  if (files.empty() || segmentation::holds_dicom(input, options)) return {};
  std::sort(files.begin(), files.end());
  return files;
}

void refuse_several(const std::string& folder, const std::vector<std::string>& files) {
  constexpr std::size_t kMost = 3;
  std::vector<std::string> names;
  for (std::size_t n = 0; n < std::min(files.size(), kMost); ++n)
    names.push_back(fs::path(files[n]).filename().string());
  throw InputError(fmt::format(
      "the folder {} holds no DICOM, but {} volumes or surfaces: {}{}. Give one of these files, as "
      "`angio run {} -o CASE`",
      folder, files.size(), fmt::join(names, ", "), files.size() > kMost ? ", ..." : "",
      files.front()));
}

std::string file_or_dicom(const std::string& input, const segmentation::ReadOptions& options) {
  const std::vector<std::string> files = files_instead_of_dicom(input, options);
  if (files.size() > 1) refuse_several(input, files);
  return files.empty() ? input : files.front();
}

}  // namespace angio::pipeline
