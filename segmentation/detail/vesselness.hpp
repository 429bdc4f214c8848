#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"

namespace angio::segmentation::detail {

/// Estimates at each voxel the contrast of a bright tube through it [intensity], the largest over
/// all scales; 0 where there is none above the noise.
///
///     C = e s^2 max(0, -l2),    l1 <= l2 <= l3 eigenvalues of the Hessian at scale s
///
/// l2 is nearly 0 at plates and edges. On the axis of a tube of radius r and contrast 1,
/// -s^2 l2 = x exp(-x) with x = r^2 / (2 s^2), which is at most 1/e, at s = r / sqrt(2): there C is
/// the contrast. Responses under 5.5 standard deviations (from the median absolute deviation over
/// the whole volume; 1.6 times as much for each axis along which the border is near) of their scale
/// count as noise.
/// Source: Sato et al., "Three-dimensional multi-scale line filter", MedIA 2(2), 1998,
///         doi:10.1016/S1361-8415(98)80009-1, whose line measure this is without the weight of l3.
///
/// @param radii_mm  one scale per radius
Volume<float> tube_contrast(const Volume<float>& volume, const std::vector<double>& radii_mm,
                            const Progress& progress);

struct Tubes {
  Volume<float> contrast;        ///< C
  Volume<std::uint8_t> is_thin;  ///< 1 where the finest scale shows one
  Volume<std::uint8_t> is_near;  ///< 1 within about a radius and a voxel of a tube of blood
};

/// The same of tubes that may hold blood alone. With the mean B at twice the scale for their
/// surroundings, at most the tissue's level T, and L that of blood, C is 0 where it is below
///
///     0.1 (L - B),    or 1.3 (T - B), but not more than 0.4 (L - B):
///
/// a strand of tissue in fat or lung would have as much; and where, in something darker than
/// tissue, a tube that is wide enough to show its full level does not come a quarter of the way
/// from tissue to blood. Among organs, where wide vessels tell the level (is_even), it is up to 0.6
/// (L - B) that is asked for, and half way to blood, inside of what is brighter than tissue, too.
/// Without a level that is told, C is left as it is, and every place is near.
Tubes find_tubes(const Volume<float>& volume, const std::vector<double>& radii_mm,
                 const BloodLevel& level, const Progress& progress);

/// Responses under so many robust deviations of their scale count as noise.
inline constexpr double kNoiseDeviations = 5.5;

/// Standard deviation of the bulk of the values, from every n-th of them.
double robust_deviation(std::span<const float> values);

/// A volume as it looks at one scale, on a grid as coarse as that allows.
struct ScaleView {
  Volume<float> smoothed;
  std::array<int, 3> factor;  ///< voxels in each of its blocks
  VolumeGeometry voxels;      ///< that it was made of
};

/// @param sigma  standard deviation of the scale [mm], what blocks and differences add counted in
ScaleView view_at_scale(const Volume<float>& volume, double sigma);

}  // namespace angio::segmentation::detail
