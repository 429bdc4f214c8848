#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace angio::segmentation::detail {

/// A file of the input: on disk, or packed in a zip archive.
struct DicomSource {
  std::filesystem::path path;  ///< of the file or of the archive
  std::int64_t entry = -1;     ///< which file of the archive; -1: not packed
};

struct DicomInput {
  std::vector<DicomSource> files;     ///< by name
  std::vector<std::string> warnings;  ///< e.g. files without read permission
};

/// The files that could be DICOM: of a folder and the folders in it, of a zip archive, those that a
/// DICOMDIR lists, or the one file given. Links are followed, but no folder is entered twice; pipes
/// and devices are passed over, and so is whatever a DICOMDIR lists outside its own folder.
///
/// @throws InputError if nothing of it can be read
DicomInput list_dicom_input(const std::filesystem::path& path);

/// The file ids that a DICOMDIR lists, each as the names of folders and file from its own folder
/// on.
/// @return nothing if the file is no DICOMDIR
std::vector<std::vector<std::string>> read_dicom_directory(const std::filesystem::path& path);

}  // namespace angio::segmentation::detail
