#pragma once

#include <string>

#include "segmentation/detail/dicom_series.hpp"

namespace angio::segmentation::detail {

/// Whether the user states a voxel size.
bool has_given_spacing(const ReadOptions& options);

/// Fills what a series lacks from the voxel size that the user states: pixel spacing, axes along
/// the patient's, and positions in the order of the instance (or frame) numbers. What the series
/// does state is kept.
///
/// @return why that cannot be done, or nothing
std::string give_spacing(DicomSeries& series, const ReadOptions& options);

/// Why a stack's own spacing is not the one that the user states, or nothing.
std::string contradiction(const VolumeGeometry& geometry, const ReadOptions& options);

}  // namespace angio::segmentation::detail
