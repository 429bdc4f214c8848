#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// Estimates at each voxel the contrast of a bright tube through it [intensity], the largest over
/// all scales; 0 where there is none above the noise.
///
///     C = e s^2 max(0, -l2),    l1 <= l2 <= l3 eigenvalues of the Hessian at scale s
///
/// l2 is nearly 0 at plates and edges. On the axis of a tube of radius r and contrast 1,
/// -s^2 l2 = x exp(-x) with x = r^2 / (2 s^2), which is at most 1/e, at s = r / sqrt(2): there C is
/// the contrast. Responses under 5.5 standard deviations (from the median absolute deviation over
/// the whole volume) of their scale count as noise.
/// Source: Sato et al., "Three-dimensional multi-scale line filter", MedIA 2(2), 1998,
///         doi:10.1016/S1361-8415(98)80009-1, whose line measure this is without the weight of l3.
///
/// @param radii_mm  one scale per radius
Volume<float> tube_contrast(const Volume<float>& volume, const std::vector<double>& radii_mm,
                            const Progress& progress);

/// Responses under so many robust deviations of their scale count as noise.
inline constexpr double kNoiseDeviations = 5.5;

/// Standard deviation of the bulk of the values, from every n-th of them.
double robust_deviation(std::span<const float> values);

/// A volume as it looks at one scale, on a grid as coarse as that allows.
struct ScaleView {
  Volume<float> smoothed;
  std::array<int, 3> factor;  ///< voxels in each of its blocks
};

/// @param sigma  standard deviation of the scale [mm], what blocks and differences add counted in
ScaleView view_at_scale(const Volume<float>& volume, double sigma);

}  // namespace angio::segmentation::detail
