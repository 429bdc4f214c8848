#include "segmentation/detail/tunnels.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <vector>

#include "core/parallel.hpp"

namespace angio::segmentation::detail {
namespace {

/// What the eight voxels around a corner of the grid add to Euler's number: the corner, and of each
/// edge, face and cube that meets there the share 1/2, 1/4, 1/8; in eighths.
/// @param set  bit x + 2 y + 4 z: the voxel on that side of the corner
int eighths_at_corner(unsigned set) {
  if (set == 0) return 0;
  int edges = 0, faces = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      // An edge along the axis, to one side of the corner, is among the four voxels there.
      unsigned beside = 0;
      for (unsigned v = 0; v < 8; ++v)
        if (int(v >> axis & 1U) == side) beside |= 1U << v;
      edges += (set & beside) != 0;
    }
  for (unsigned v = 0; v < 8; ++v)  // a face is between two voxels that differ along one axis
    for (unsigned axis = 0; axis < 3; ++axis)
      if ((v >> axis & 1U) == 0) faces += (set & (1U << v | 1U << (v | 1U << axis))) != 0;
  return 8 - 4 * edges + 2 * faces - std::popcount(set);
}

}  // namespace

std::int64_t least_tunnels(const Volume<std::uint8_t>& mask) {
  std::array<int, 256> eighths{};
  for (unsigned set = 0; set < 256; ++set) eighths[set] = eighths_at_corner(set);
  const auto [ni, nj, nk] = mask.geometry.size;
  std::vector<std::int64_t> sums(std::size_t(nk) + 1, 0);
  parallel_for(nk + 1, [&, ni = ni, nj = nj, nk = nk](std::ptrdiff_t k) {
    const auto at = [&](int i, int j, int layer) {
      return i >= 0 && i < ni && j >= 0 && j < nj && layer >= 0 && layer < nk &&
             mask.at(i, j, layer) != 0;
    };
    for (int j = 0; j <= nj; ++j) {
      unsigned set = 0;
      for (int i = 0; i <= ni; ++i) {
        set = set >> 1 & 0b01010101U;  // what lay beyond the last corner lies before this one
        for (unsigned side = 0; side < 4; ++side)
          set |= unsigned(at(i, j - 1 + int(side & 1U), int(k) - 1 + int(side >> 1)))
                 << (2 * side + 1);
        sums[std::size_t(k)] += eighths[set];
      }
    }
  });
  std::int64_t eight_times = 0;
  for (const std::int64_t sum : sums) eight_times += sum;
  return std::max<std::int64_t>(1 - eight_times / 8, 0);
}

}  // namespace angio::segmentation::detail
