#pragma once

#include <array>
#include <cstddef>

#include "core/volume.hpp"

/// Grids to draw test images on.
namespace angio::test {

/// A grid around the origin.
inline VolumeGeometry grid_of(const std::array<int, 3>& size, const Vec3& spacing) {
  VolumeGeometry grid;
  grid.size = size;
  grid.spacing = spacing;
  for (int a = 0; a < 3; ++a) grid.origin[a] = -0.5 * (size[std::size_t(a)] - 1) * spacing[a];
  return grid;
}

/// Calls body(place in LPS, voxel).
template <class Body>
void for_each_voxel(const VolumeGeometry& grid, const Body& body) {
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        body(grid.lps_from_index({double(i), double(j), double(k)}), grid.offset(i, j, k));
}

}  // namespace angio::test
