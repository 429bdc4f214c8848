#pragma once

#include <vector>

#include "core/progress.hpp"
#include "segmentation/detail/dicom_series.hpp"

namespace angio::segmentation::detail {

/// Decodes every frame of one object: value = slope * stored + intercept, frame by frame, with
/// MONOCHROME1 inverted first and padding set to the least other value of the frame.
///
/// Compressed pixels are decoded in a child process, so that a damaged stream cannot take the
/// program down with it.
///
/// @return shape [frame_count, rows, columns]
/// @throws InputError if the pixels are truncated or damaged
std::vector<float> decode_frames(const DicomHeader& header);

/// The voxels of a usable series, in the order of its slices, shape [size k, size j, size i].
std::vector<float> decode_series(const DicomSeries& series, const Progress& progress);

}  // namespace angio::segmentation::detail
