#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "segmentation/detail/dicom_series.hpp"
#include "segmentation/dicom_segmentation.hpp"

namespace angio::segmentation::detail {

/// The lumen on those source slices that hold some of it.
struct SegmentationFrames {
  std::vector<SliceReference> slices;            ///< of the source, in the order of growing k
  std::vector<std::vector<std::uint8_t>> masks;  ///< shape [rows, columns] each, 1 inside
};

/// Writes a DICOM Segmentation object with DCMTK's dcmseg; to be used in a guarded child only.
/// @throws IoError if it cannot be made or written
void write_segmentation_object(const std::filesystem::path& path, const DicomSeries& series,
                               const SegmentationFrames& frames,
                               const DicomSegmentationOptions& options);

}  // namespace angio::segmentation::detail
