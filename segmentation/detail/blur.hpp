#pragma once

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// Standard deviation [mm] of the blur across a boundary, measured on the image itself: the level
/// follows the blurred step u = Phi(-d / sigma), so that the normal quantile of its mean at each
/// distance d is a line in d. At most 1.5 voxels.
///
/// @param level     1/2 - u, negative inside, on the image's grid
/// @param distance  d [mm], signed
double blur_across(const Volume<float>& level, const Volume<float>& distance);

/// Moves the half level of a blurred bent surface back to where the surface is:
///
///     d <- d - sigma^2 / 2 (k1 + k2),    k1 + k2 = laplace d
///
/// to first order in sigma k; at most half of sigma is given back. The curvature is that of the
/// distance smoothed by `smoothing_mm`.
Volume<float> undo_blur(const Volume<float>& distance, double sigma_mm, double smoothing_mm);

/// The inverse of the standard normal distribution, by bisection.
/// @param share  in (0, 1)
double normal_quantile(double share);

/// The geometric mean of a voxel's edges [mm].
double mean_spacing(const VolumeGeometry& geometry);

}  // namespace angio::segmentation::detail
