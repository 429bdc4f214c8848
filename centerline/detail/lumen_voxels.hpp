#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/volume.hpp"

namespace angio::centerline {

/// The voxels of one connected lumen as a graph. Two voxels are linked when the level set,
/// interpolated between their centres, stays inside: diagonal steps through the wall of two
/// touching vessels do not exist.
struct LumenVoxels {
  VolumeGeometry geometry;
  std::array<int, 3> corner{0, 0, 0};  ///< of the box around the lumen, in the volume's index
  std::array<int, 3> size{0, 0, 0};    ///< of the box
  std::vector<int> voxel_of_cell;      ///< -1 outside, shape [size k, size j, size i]
  std::vector<int> cell;               ///< shape [voxel]
  std::vector<std::uint32_t> links;    ///< bit n: linked to neighbour n of kOffsets, shape [voxel]
  std::vector<float> depth;            ///< distance to the wall [mm], shape [voxel]

  [[nodiscard]] int count() const { return int(cell.size()); }
  [[nodiscard]] std::array<int, 3> index(int voxel) const;    ///< in the box
  [[nodiscard]] Vec3 position(int voxel) const;               ///< LPS [mm]
  [[nodiscard]] inline int neighbor(int voxel, int n) const;  ///< -1 when not linked
  [[nodiscard]] int nearest(const Vec3& point_in_lps) const;
  /// The depth between voxels, linear, 0 at voxels outside [mm].
  [[nodiscard]] double depth_at(const Vec3& point_in_lps) const;
  void cut(int voxel, int n);  ///< removes the link, both ways
};

inline constexpr int kNeighborCount = 26;
/// The 26 neighbours of a voxel; the opposite of n is 25 - n.
inline constexpr auto kNeighborOffsets = [] {
  std::array<std::array<int, 3>, kNeighborCount> result{};
  std::size_t n = 0;
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        if (i != 0 || j != 0 || k != 0) result[n++] = {i, j, k};
  return result;
}();
/// Their distances [mm] on this grid.
std::array<double, kNeighborCount> neighbor_lengths(const VolumeGeometry& geometry);

inline int LumenVoxels::neighbor(int voxel, int n) const {
  if ((links[std::size_t(voxel)] >> n & 1U) == 0) return -1;
  const auto& o = kNeighborOffsets[std::size_t(n)];
  return voxel_of_cell[std::size_t(cell[std::size_t(voxel)] + (o[2] * size[1] + o[1]) * size[0] +
                                   o[0])];
}

/// The links of a voxel inside a level set, given by its index in the volume.
std::uint32_t find_links(const Volume<float>& level_set, const std::array<int, 3>& at);

struct LumenPieces {
  std::vector<LumenVoxels> pieces;  ///< that may hold a tree, the largest first
  std::vector<double> voxel_share;  ///< of all lumen voxels, shape [piece]
  int piece_count = 0;              ///< connected pieces in the level set, small ones too
};

/// Takes the connected pieces of {level_set < 0} that hold at least 5 % of the largest one's
/// voxels, and the distance of their voxels to the wall. The distance is built anew from the
/// sub-voxel zero crossings (each voxel inherits the nearest crossing of its neighbours), so the
/// level set need only be right near the wall. The border of the volume is not a wall.
///
/// @throws InputError  when nothing is inside
LumenPieces find_lumen_pieces(const Volume<float>& level_set);

}  // namespace angio::centerline
