#pragma once

#include <array>
#include <limits>
#include <vector>

#include "centerline/detail/wall.hpp"
#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"

namespace angio::centerline {

/// A surface made ready for measuring.
struct ClosedSurface {
  TriangleMesh mesh;
  int wall_vertex_count = 0;  ///< the vertices after these are the middles of caps
};

/// Vertices at the same place are joined, degenerate triangles dropped, rims closed by fans around
/// their middle, triangles turned alike within each piece, normals outward.
/// @throws InputError  when it encloses nothing, or indices or coordinates are broken
ClosedSurface close_surface(const TriangleMesh& surface);

/// A closed triangle surface as a wall: rays are traced through a tree of boxes.
class SurfaceWall final : public Wall {
 public:
  /// @param closed      from close_surface
  /// @param resolution  size of the detail to look at [mm]; 0: half the mean edge
  explicit SurfaceWall(TriangleMesh closed, double resolution = 0.0);
  [[nodiscard]] double ray(const Vec3& from, const Vec3& direction, double longest) const override;
  [[nodiscard]] bool inside(const Vec3&) const override { return true; }
  [[nodiscard]] double depth_in_data(const Vec3&) const override {
    return std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] double resolution() const override { return resolution_; }
  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
  /// Distance [mm] to the nearest triangle without a vertex of index `first_cap_vertex` or more.
  [[nodiscard]] double distance_to_wall(const Vec3& point, int first_cap_vertex) const;
  /// Lumen diameters [mm] as seen from the wall: straight across, from the middles of up to
  /// `most` triangles spread over the surface; ascending.
  [[nodiscard]] std::vector<double> diameters(int most) const;

 private:
  struct Box {
    Vec3 low, high;
    int left = -1;             ///< children are left and left + 1; -1 for a leaf
    int first = 0, count = 0;  ///< triangles of a leaf, in order_
  };
  void split(int box);
  [[nodiscard]] double first_hit(const Vec3& from, const Vec3& direction, double nearest_allowed,
                                 double longest, int& triangle) const;

  TriangleMesh mesh_;
  std::vector<Box> boxes_;
  std::vector<int> order_;
  std::vector<Vec3> middle_;
  double resolution_;
};

/// Squared distance from a point to a triangle [mm^2].
double distance_squared(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Signed distance [mm], negative inside, exact within two voxels of the surface and clamped to
/// +-2 voxels beyond. Inside is where the winding number is positive, so parts that overlap unite.
Volume<float> voxelize(const TriangleMesh& closed, double spacing_mm);

}  // namespace angio::centerline
