#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/progress.hpp"
#include "core/scratch_folder.hpp"

namespace angio::pipeline {

/// A scan on disk. One that an archive holds ("pacs://...") is fetched into a folder that only its
/// owner can read, and that is removed with this.
class FetchedScan {
 public:
  /// @param input    a path, taken as it is, or an archive's location
  /// @param calling  our application entity title towards the archive; empty: "ANGIO"
  /// @throws Error as dicom::fetch_from_archive
  FetchedScan(const std::string& input, const std::string& calling, const Progress& progress = {});

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::optional<ScratchFolder> folder_;
};

}  // namespace angio::pipeline
