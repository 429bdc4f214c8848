#pragma once

#include <cstdint>
#include <functional>
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

/// A frame's pixels as they are stored, not yet masked, signed or rescaled.
using StoredPixels = std::vector<std::uint16_t>;

/// Decodes frames one by one, in a child process, and hands each to `use` as it comes; what that
/// throws ends the child and is thrown on.
void decode_each(const std::vector<DicomHeader>& headers,
                 const std::vector<SliceReference>& members,
                 const std::function<void(std::size_t member, const StoredPixels& pixels)>& use);

/// A frame's values, as decode_frames() gives them.
/// @param values  shape [rows, columns]
void rescale(const DicomHeader& header, int frame, const StoredPixels& pixels, float* values);

/// A number per frame that is the same for the same stored pixels, and hardly ever otherwise.
std::vector<std::uint64_t> hash_frames(const std::vector<DicomHeader>& headers,
                                       const std::vector<SliceReference>& members);

}  // namespace angio::segmentation::detail
