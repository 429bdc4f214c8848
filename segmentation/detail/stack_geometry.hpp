#pragma once

#include <string>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/dicom_header.hpp"

namespace angio::segmentation::detail {

/// Where the slices of a stack lie, or why they form no volume.
struct StackGeometry {
  VolumeGeometry geometry;            ///< the regular grid: LPS, right-handed
  std::vector<int> order;             ///< the given frames in the order of growing k
  std::vector<Vec3> places;           ///< of their first pixels on the grid's axes, from its
                                      ///< origin [mm]; empty if the slices are the grid's own
  bool even_heights = true;           ///< one slice of the grid per slice
  double tilt_degrees = 0.0;          ///< between the path of the slices and their normal
  std::string problem;                ///< empty if it is a volume
  std::vector<std::string> warnings;  ///< e.g. an unevenness that was tolerated
};

enum class UnevenSlices { refuse, resample };

/// The grid of a stack of parallel slices, told from positions and orientations alone.
///
///     n = i x j,   z_k = p_k . n ascending,   spacing_k = (z_last - z_0) / (count - 1)
///
/// A slice may lie off its place by 1 % of the spacing; up to 5 % is told in a warning. A path of
/// evenly spaced slices that leans by up to 45 degrees from n (gantry tilt) gives the upright grid
/// around all of them, and `places` to resample from; with UnevenSlices::resample, so do missing
/// and unevenly spaced slices. Refused are one slice alone, different orientations, and positions
/// that repeat.
/// Source: DICOM PS3.3 C.7.6.2.1.1 (Eq. C.7.6.2.1-1). The tilt attribute (0018,1120) is not used.
StackGeometry stack_geometry(const std::vector<DicomFrame>& frames, int columns, int rows,
                             UnevenSlices uneven = UnevenSlices::refuse);

/// The frames at places that another one has already, in groups of the same place; empty if there
/// are none or the geometry is incomplete.
std::vector<std::vector<int>> repeated_places(const std::vector<DicomFrame>& frames);

/// The voxels of a stack whose slices do not lie on the grid: each slice is shifted within its
/// plane by cubic B-splines, which is exact for cubic polynomials; then, where slices are unevenly
/// spaced, the values between them by cubic Hermite polynomials (exact for quadratic ones) along n.
/// Voxels that no slice covers take the lowest value of all.
///
/// @param slices  in the order of StackGeometry::order, shape [count, rows, columns]
std::vector<float> resample_stack(const std::vector<float>& slices, int columns, int rows,
                                  const StackGeometry& stack);

}  // namespace angio::segmentation::detail
