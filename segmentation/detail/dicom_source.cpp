#include "segmentation/detail/dicom_source.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "segmentation/detail/zip_archive.hpp"

namespace angio::segmentation::detail {
namespace fs = std::filesystem;
namespace {

constexpr int kMaxFolderDepth = 64;

/// Gathers the plain files under a folder.
class FolderWalk {
 public:
  void enter(const fs::path& folder, int depth = 0) {
    struct stat status {};
    if (stat(folder.c_str(), &status) != 0 ||
        !seen_.insert({std::uint64_t(status.st_dev), std::uint64_t(status.st_ino)}).second)
      return;
    std::error_code error;
    auto entry = fs::directory_iterator(folder, error);
    if (error || depth > kMaxFolderDepth) {
      ++unreadable_;
      return;
    }
    std::vector<fs::path> folders;
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
      std::error_code ignored;  // a link to nowhere is no file
      if (entry->is_directory(ignored))
        folders.push_back(entry->path());
      else if (entry->is_regular_file(ignored) && entry->file_size(ignored) > 0)
        add(entry->path());
    }
    if (error) ++unreadable_;
    std::sort(folders.begin(), folders.end());
    for (const auto& inner : folders) enter(inner, depth + 1);
  }

  DicomInput take() {
    std::sort(input_.files.begin(), input_.files.end(),  // a folder's order is the system's whim
              [](const DicomSource& a, const DicomSource& b) { return a.path < b.path; });
    if (unreadable_ > 0)
      input_.warnings.push_back(std::to_string(unreadable_) +
                                " files or folders cannot be opened (check their permissions); "
                                "they were left out");
    return std::move(input_);
  }

 private:
  void add(const fs::path& file) {
    if (access(file.c_str(), R_OK) == 0)
      input_.files.push_back({file, -1});
    else
      ++unreadable_;
  }

  std::set<std::pair<std::uint64_t, std::uint64_t>> seen_;  ///< device and inode
  int unreadable_ = 0;
  DicomInput input_;
};

/// A name in a folder, written in any case: discs are mounted in capitals or without.
fs::path find_name(const fs::path& folder, const std::string& name) {
  std::error_code error;
  if (fs::exists(folder / name, error)) return folder / name;
  for (auto entry = fs::directory_iterator(folder, error);
       !error && entry != fs::directory_iterator(); entry.increment(error))
    if (lower_case(entry->path().filename().string()) == lower_case(name)) return entry->path();
  return {};
}

/// Where a file id leads, or nothing if it leads out of the folder or nowhere.
fs::path resolve(const fs::path& root, const std::vector<std::string>& names) {
  fs::path place = root;
  for (const std::string& name : names) {
    if (name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos)
      return {};
    place = find_name(place, name);
    if (place.empty()) return {};
  }
  std::error_code error;
  const fs::path real = fs::canonical(place, error);
  if (error || !fs::is_regular_file(real, error)) return {};
  const fs::path real_root = fs::canonical(root, error);
  const auto [end_of_root, unused] =
      std::mismatch(real_root.begin(), real_root.end(), real.begin(), real.end());
  return end_of_root == real_root.end() ? place : fs::path();
}

DicomInput list_directory(const fs::path& dicomdir,
                          const std::vector<std::vector<std::string>>& file_ids) {
  const fs::path root = dicomdir.has_parent_path() ? dicomdir.parent_path() : fs::path(".");
  DicomInput input;
  std::set<fs::path> listed;
  int missing = 0;
  for (const auto& names : file_ids) {
    const fs::path place = resolve(root, names);
    if (place.empty() || access(place.c_str(), R_OK) != 0)
      ++missing;
    else
      listed.insert(place);
  }
  for (const auto& place : listed) input.files.push_back({place, -1});
  if (missing > 0)
    input.warnings.push_back(std::to_string(missing) + " of the " +
                             std::to_string(file_ids.size()) +
                             " files that the DICOMDIR lists are not in its folder");
  if (listed.empty())
    throw InputError(
        "none of the files that the DICOMDIR lists is in its folder (it was copied alone). Copy "
        "the whole disc, or give the folder of the series");
  return input;
}

DicomInput list_archive(const fs::path& path) {
  DicomInput input;
  ChildLimits limits;
  limits.reach.read = {path};
  const ChildResult result = run_guarded(
      limits,
      [&](ChildOutput& output) {
        std::vector<std::int64_t> entries;
        for (const auto& entry : ZipArchive(path).entries()) entries.push_back(entry.index);
        output.put(entries);
      },
      [&](ChildInput& from) {
        std::vector<std::int64_t> entries;
        from.get(entries);
        for (const std::int64_t entry : entries) input.files.push_back({path, entry});
      });
  if (result.end == ChildEnd::refused) throw InputError(result.message);
  if (result.end != ChildEnd::done)
    throw InputError(
        "cannot read the zip archive (it is damaged). Unpack it, and give the folder instead");
  return input;
}

}  // namespace

DicomInput list_dicom_input(const fs::path& path) {
  if (fs::is_directory(path)) {
    FolderWalk walk;
    walk.enter(path);
    return walk.take();
  }
  if (!fs::exists(path))
    throw InputError("there is no " + path.string() + " (no such file or folder). Check the path",
                     ExitCode::no_input);
  if (!fs::is_regular_file(path))
    throw InputError(
        "the input is neither a file nor a folder (a pipe or a device cannot be read twice). Give "
        "a DICOM folder or a file");
  if (access(path.c_str(), R_OK) != 0)
    throw InputError("the input cannot be opened. Check its permissions", ExitCode::no_input);
  if (is_zip_archive(path)) return list_archive(path);
  const auto file_ids = read_dicom_directory(path);
  return file_ids.empty() ? DicomInput{{{path, -1}}, {}} : list_directory(path, file_ids);
}

}  // namespace angio::segmentation::detail
