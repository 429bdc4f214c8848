#pragma once

#include <cstddef>

#include "core/centerline.hpp"

namespace angio::benchmarks {

/// Moves lines by their mean offset from the true ones: what all of a C-arm is moved by cannot be
/// seen in its frames. Again, for the nearest true places change with it.
///
/// @param true_place  (line's index, place) -> the true place nearest to it
/// @return the whole move [mm]
template <typename TruePlace>
Vec3 move_freely(CenterlineTree& tree, const TruePlace& true_place) {
  constexpr int kRounds = 5;
  Vec3 moved;
  for (int round = 0; round < kRounds; ++round) {
    Vec3 by;
    double count = 0.0;
    for (std::size_t line = 0; line < tree.paths.size(); ++line)
      for (const Vec3& point : tree.paths[line].points) {
        by += true_place(line, point) - point;
        count += 1.0;
      }
    by = by / count;
    moved += by;
    for (CenterlinePath& path : tree.paths)
      for (Vec3& point : path.points) point += by;
  }
  return moved;
}

}  // namespace angio::benchmarks
