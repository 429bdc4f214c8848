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

/// The same as runs of voxels along i, which need far less memory.
struct Pieces {
  struct Run {
    int first, last;  ///< voxels [first, last) of row (j, k)
    int j, k;
    std::int32_t label;
  };
  std::vector<Run> runs;                    ///< row by row
  std::vector<std::size_t> voxel_count{0};  ///< shape [piece_count + 1]; [0] is unused
  [[nodiscard]] int count() const { return int(voxel_count.size()) - 1; }
};

/// Labels in the order of each piece's first voxel.
Pieces find_pieces(const Volume<std::uint8_t>& mask, Connectivity connectivity);
/// Of where a level is negative, or is not; joined by faces.
Pieces find_pieces_inside(const Volume<float>& level);
Pieces find_pieces_outside(const Volume<float>& level);
Components label_components(const Volume<std::uint8_t>& mask, Connectivity connectivity);

/// The smallest box around the set voxels, grown by a margin and clipped to the grid.
/// @param margin_mm  at least three voxels are added
VoxelBox bounding_box(const Volume<std::uint8_t>& mask, double margin_mm);

}  // namespace angio::segmentation::detail
