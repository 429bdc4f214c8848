#pragma once

#include <cstdint>
#include <vector>

#include "core/progress.hpp"
#include "segmentation/detail/dicom_series.hpp"

namespace angio::segmentation::detail {

/// Decodes some frames: value = slope * stored + intercept, frame by frame, with MONOCHROME1
/// inverted first and padding set to the least other value of the frame.
///
/// The pixels are read and decoded in a child process, so that a damaged file cannot take the
/// program down with it.
///
/// @param members  all of the same size
/// @return shape [member count, rows, columns]
/// @throws InputError if the pixels are truncated or damaged
std::vector<float> decode_frames(const std::vector<DicomHeader>& headers,
                                 const std::vector<SliceReference>& members,
                                 const Progress& progress = {});

/// The same, put where the caller wants them.
void decode_frames(const std::vector<DicomHeader>& headers,
                   const std::vector<SliceReference>& members, float* values,
                   const Progress& progress = {});

/// A number per frame that is the same for the same stored pixels, and hardly ever otherwise.
std::vector<std::uint64_t> hash_frames(const std::vector<DicomHeader>& headers,
                                       const std::vector<SliceReference>& members);

}  // namespace angio::segmentation::detail
