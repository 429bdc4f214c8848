#pragma once

#include <cstdint>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/edge_image.hpp"
#include "segmentation/detail/intensity_levels.hpp"

namespace angio::segmentation::detail {

/// What the image is explained by, apart from the boundary.
struct EdgeModel {
  const Volume<float>& image;              ///< as it was scanned, not denoised
  const IntensityLevels& levels;           ///< L and B
  const Volume<std::uint8_t>& is_foreign;  ///< voxels that the model does not explain
  double noise_share = 0.0;                ///< standard deviation / contrast
  float least_contrast = 0.0f;             ///< L - B counts as no less
  float intensity_min = -1e30f;            ///< the boundary lies at no lower intensity
  bool blur_is_known = false;              ///< it is not fitted
};

/// Moves a boundary until the image that it would give is the image that was scanned.
///
///     I(x) = B + (L - B) S(x),    S = G * P(phi)
///
/// P is the part of each voxel inside {phi < 0} (its plane's, moved by the curvature that a voxel's
/// box takes away, h^2 / 24 (k1 + k2)), G the scanner's Gaussian on the voxels (Lindeberg's
/// discrete one: its variance is exact however narrow it is, and dG/d(sd^2) is half its second
/// difference). With e = (I - B) / (L - B) - S each step moves the boundary outwards by the shift
/// that explains e best around each place, and widens the blur by what is left:
///
///     u = K * (|grad S| e) / K * |grad S|^2,    phi <- phi - u,
///     sd_a^2 <- sd_a^2 + sum(e q_a) / sum(q_a^2),    q_a = second difference of S along a / 2
///
/// The steps, not the surface, are smoothed (K: one voxel at 4 % noise), so that they bring no
/// noise in and the surface does not shrink: wherever it comes to rest, the image holds nothing
/// more to tell it at that scale. Bias from blur and curvature is undone to all orders that way.
/// Where more than noise is left unexplained (values that were clipped, walls that touch), K is as
/// wide as that much noise would ask for, and the surface is smoothed between the steps.
///
/// @param phi    signed distance [mm] on the fine grid, valid for three voxels to each side; moved
/// @param blur   starting value; improved
/// @param steps  to take
void fit_edges(Volume<float>& phi, const FineGrid& fine, const EdgeModel& model, Blur& blur,
               int steps);

}  // namespace angio::segmentation::detail
