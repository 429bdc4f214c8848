#pragma once

#include <cstddef>
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

}  // namespace angio::segmentation::detail
