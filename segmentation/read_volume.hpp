#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"

namespace angio::segmentation {

struct ReadOptions {
  std::string series;        ///< number (1...) or hash from `inspect`; empty: by rule (most voxels)
  bool allow_lossy = false;  ///< measure on lossy-compressed pixels all the same
};

struct LoadedVolume {
  Volume<float> volume;
  std::string source_description;     ///< e.g. "CT Image Storage, 256 slices"; no identity
  std::vector<std::string> warnings;  ///< e.g. series that were left out, and why
};

/// Reads a DICOM folder or file, .nrrd .nhdr .mha .mhd .nii .nii.gz .vti.
/// @throws InputError (65, or 66 if there is nothing) with the reason and what to do
LoadedVolume read_volume(const std::filesystem::path& path, const ReadOptions& options,
                         const Progress& progress = {});

/// One series (or volume file) as `angio inspect` lists it. Nothing in it identifies a patient.
struct SeriesSummary {
  std::string key;   ///< short hash of the series UID, or the file's format
  std::string kind;  ///< SOP class in words, e.g. "CT Image Storage"
  std::string transfer_syntax;
  VolumeGeometry geometry;  ///< meaningful if usable
  int file_count = 0;
  int frame_count = 0;
  bool usable = false;
  std::string verdict;  ///< "regular grid", or why it is refused and what to do
};

/// Reads headers only.
std::vector<SeriesSummary> inspect(const std::filesystem::path& path);

/// Writes .nrrd (LPS, gzip), atomically.
void write_volume(const std::filesystem::path& path, const Volume<float>& volume);
void write_volume(const std::filesystem::path& path, const Volume<std::uint8_t>& volume);
/// Reads back what write_volume wrote (any volume file; no DICOM).
Volume<float> read_volume_file(const std::filesystem::path& path);

}  // namespace angio::segmentation
