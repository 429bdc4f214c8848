#pragma once

#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// Makes the lumen of a label map: the labels asked for, or all; of their pieces the largest, or
/// those with a seed; with a smooth boundary (find_label_boundary). Its volume is compared with the
/// labels', and a difference of over 1 % told.
///
/// @param labels  of the volume (find_labels)
/// @throws InputError if a label asked for does not occur, or nothing is left
Segmentation segment_label_map(const Volume<float>& volume, const std::vector<Label>& labels,
                               const SegmentationOptions& options, const Progress& progress);

}  // namespace angio::segmentation::detail
