#pragma once

#include <vector>

#include "segmentation/detail/dicom_series.hpp"

namespace angio::segmentation::detail {

/// Sorts out slices at the same place. If a phase (stack, time, echo, acquisition, kind of image)
/// tells them apart, each phase becomes a series of its own. Copies with the same pixels are
/// dropped, with a warning. Otherwise the series stays as it is, and will be refused.
std::vector<DicomSeries> settle_repeats(DicomSeries series);

}  // namespace angio::segmentation::detail
