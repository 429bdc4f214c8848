#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "centerline/detail/lumen_voxels.hpp"
#include "core/volume.hpp"

namespace angio::centerline {

/// Points on the wall of a lumen, found by their place: what a level set and a surface have in
/// common when they are measured.
///
/// A surface gives its vertices, not its flat triangles: these lie inside the round wall between
/// them, by 1 - cos(pi / n) of the radius where n vertices stand round the vessel.
class WallPoints {
 public:
  /// The zero crossings of a level set along the grid lines that leave the lumen, by the cubic
  /// through four voxels (the straight line through two is wrong by h^2 / 12 r and more).
  /// @param voxel_mm  longest edge of the voxels that it was found in; less than its own: its own
  WallPoints(const Volume<float>& level_set, const LumenVoxels& lumen, double voxel_mm);
  /// The vertices of a surface.
  explicit WallPoints(std::vector<Vec3> vertices);

  [[nodiscard]] const Vec3& point(int index) const { return points_[std::size_t(index)]; }
  [[nodiscard]] int count() const { return int(points_.size()); }
  /// Points within `reach` [mm] of a place, in a fixed order.
  void collect(const Vec3& center, double reach, std::vector<int>& found) const;
  /// Distance [mm] to the nearest point. @param guess  [mm] > 0: where to begin to look
  [[nodiscard]] double distance_to_nearest(const Vec3& place, double guess) const;
  /// Errors of points nearer than this [mm] go together.
  [[nodiscard]] double correlation_length() const { return correlation_length_; }

 private:
  using Key = std::array<int, 3>;  ///< of a cell: k, j, i
  struct Cell {
    int i, first;  ///< of its points; the next cell's first ends them
  };
  struct Row {
    int k, j;
    int begin, end;  ///< of its cells
  };
  void build_grid(double cell);
  [[nodiscard]] Key key_of(const Vec3& p) const;
  /// Squared distance [mm^2] to the nearest point that is nearer than `bound`; else `bound`.
  [[nodiscard]] double nearest_squared(const Vec3& place, double bound) const;

  std::vector<Vec3> points_;  ///< cell by cell, row by row
  std::vector<Cell> cells_;   ///< of all rows, and one behind
  std::vector<Row> rows_;
  double cell_ = 1.0;
  double correlation_length_ = 0.0;
};

}  // namespace angio::centerline
