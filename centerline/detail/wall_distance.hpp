#pragma once

#include "centerline/detail/surface_wall.hpp"
#include "centerline/detail/wall_points.hpp"

namespace angio::centerline {

/// How far the wall is from a place, straight from the data: a surface's triangles, or the zero
/// crossings of a level set, which lie much closer than the wall bends.
class WallDistance {
 public:
  explicit WallDistance(const WallPoints& points) : points_(points) {}
  /// @param triangles  closed by caps, which are no wall; must outlive this
  /// @param wall_vertex_count  vertices from this one on belong to caps
  WallDistance(const WallPoints& points, const SurfaceWall& triangles, int wall_vertex_count)
      : points_(points), triangles_(&triangles), wall_vertex_count_(wall_vertex_count) {}

  /// [mm] @param guess  [mm] > 0: the distance so far; only speed depends on it
  [[nodiscard]] double at(const Vec3& place, double guess) const {
    return triangles_ != nullptr ? triangles_->distance_to_wall(place, wall_vertex_count_)
                                 : points_.distance_to_nearest(place, guess);
  }

 private:
  const WallPoints& points_;
  const SurfaceWall* triangles_ = nullptr;
  int wall_vertex_count_ = 0;
};

}  // namespace angio::centerline
