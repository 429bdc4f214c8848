#pragma once

#include <cstdint>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {

/// Connected pieces of the set voxels of a mask.
struct Components {
  std::vector<std::int32_t> label;       ///< 0 outside, else 1, 2, ..., shape [voxel_count]
  std::vector<std::size_t> voxel_count;  ///< shape [component_count + 1]; [0] is unused
  [[nodiscard]] int count() const { return int(voxel_count.size()) - 1; }
};

enum class Connectivity { faces = 6, corners = 26 };

/// Labels in the order of each piece's first voxel.
Components label_components(const Volume<std::uint8_t>& mask, Connectivity connectivity);

/// The smallest box around the set voxels, grown by a margin and clipped to the grid.
/// @param margin_mm  at least three voxels are added
VoxelBox bounding_box(const Volume<std::uint8_t>& mask, double margin_mm);

}  // namespace angio::segmentation::detail
