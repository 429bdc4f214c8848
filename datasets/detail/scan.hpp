#pragma once

#include <cstdint>

#include "core/progress.hpp"
#include "core/volume.hpp"
#include "datasets/detail/lumen_shape.hpp"

/// What a scanner makes of a lumen: partial volume, blur, noise.
namespace angio::datasets::detail {

/// The grid of voxels around a lumen with `margin_mm` of background on every side.
VolumeGeometry grid_around(const LumenShape& shape, const Vec3& spacing_mm, double margin_mm,
                           const Mat3& direction = Mat3::identity());

/// The part of each voxel inside the lumen, in [0, 1]. Cells at the wall are halved until they are
/// small against the local radius; what is left is cut by the wall's tangent plane.
Volume<float> lumen_fraction(const LumenShape& shape, const VolumeGeometry& geometry,
                             const Progress& progress);

/// The part of the unit cube below a plane: { y : |y_i| <= 1/2, n . y + offset <= 0 }.
///
///     V = 1 / (6 a b c) sum_{v in {0,1}^3} (-1)^|v| max(0, d - v . (a, b, c))^3,
///     (a, b, c) = |n|, d = (a + b + c) / 2 - offset
///
/// Source: Scardovelli, Zaleski, J. Comput. Phys. 164:228, 2000, doi:10.1006/jcph.2000.6567
///         (forward problem of section 2).
///
/// @param normal  unit
double fraction_below_plane(const Vec3& normal, double offset);

/// Convolves with a Gaussian along each axis, cut at 4 standard deviations; at the border the
/// nearest voxel is repeated.
///
/// @param sd_voxels  along each axis; all zero: none
void blur(Volume<float>& volume, const Vec3& sd_voxels);

/// A standard normal number that depends on seed and counter alone (SplitMix64, Box-Muller).
double normal_number(std::uint64_t seed, std::uint64_t counter);

}  // namespace angio::datasets::detail
