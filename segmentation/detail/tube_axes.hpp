#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// The middle line of a bright tube with a full profile, as a cloud of voxels.
struct TubeAxis {
  double radius_mm = 0.0;           ///< of the scale that shows it
  std::vector<std::size_t> voxels;  ///< of the volume, nearest to each place
  double length_share = 0.0;        ///< length that each place stands for [mm], roughly
  std::vector<float> intensity;     ///< at each place, shape [place_count]
  std::vector<float> contrast;      ///< against the surroundings, shape [place_count]
};

/// Finds tubes by shape alone, of any brightness, at radii from 2.2 voxels to 15 mm.
///
/// A place is on an axis if l1 <= l2 << 0 are alike and l3 is small (eigenvalues of the Hessian at
/// the scale), the gradient vanishes, and the contrast that l2 tells (tube_contrast) is that
/// against the surroundings at two radii. Plates, spheres and edges fail that. Places that touch
/// make an axis if they span three radii or more.
std::vector<TubeAxis> find_tube_axes(const Volume<float>& volume);

/// The places of axes that keep(axis, n) is true for.
template <class Keep>
std::vector<TubeAxis> parts_of(const std::vector<TubeAxis>& axes, const Keep& keep) {
  std::vector<TubeAxis> parts;
  for (const TubeAxis& axis : axes) {
    TubeAxis part{axis.radius_mm, {}, axis.length_share, {}, {}};
    for (std::size_t n = 0; n < axis.voxels.size(); ++n) {
      if (!keep(axis, n)) continue;
      part.voxels.push_back(axis.voxels[n]);
      part.intensity.push_back(axis.intensity[n]);
      part.contrast.push_back(axis.contrast[n]);
    }
    if (!part.voxels.empty()) parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace angio::segmentation::detail
