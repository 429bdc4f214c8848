#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/vec3.hpp"
#include "dicom/identity.hpp"

namespace angio::segmentation::detail {

/// One frame of the object: where it lies, and the image that it was drawn on.
struct SegmentationPlane {
  Vec3 position;               ///< of the first pixel's centre, LPS [mm]
  dicom::SourceObject source;  ///< empty: none
  int source_frame = -1;       ///< of an object of many frames, from 0; -1: the image has one
};

/// The lumen on parallel planes of equal pixels.
struct SegmentationFrames {
  int rows = 0, columns = 0;
  double spacing_i = 0.0, spacing_j = 0.0;       ///< between columns, between rows [mm]
  double thickness = 0.0;                        ///< [mm]
  Vec3 axis_i, axis_j;                           ///< of growing column, of growing row
  std::string source_series_uid;                 ///< empty: there is no source
  std::vector<SegmentationPlane> planes;         ///< those that hold some lumen, at least one
  std::vector<std::vector<std::uint8_t>> masks;  ///< shape [rows, columns] each, 1 inside
};

/// Names the object's UIDs: the source and the lumen in it.
std::string seed_of(const SegmentationFrames& frames);

/// Writes a DICOM Segmentation object with DCMTK's dcmseg.
/// @param seed  of the object's UIDs
/// @throws IoError if it cannot be made or written
void write_segmentation_object(const std::filesystem::path& path, const SegmentationFrames& frames,
                               const dicom::StudyIdentity& identity, const std::string& seed);

}  // namespace angio::segmentation::detail
