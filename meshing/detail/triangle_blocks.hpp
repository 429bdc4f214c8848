#pragma once

#include <span>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

struct Ball {
  Vec3 middle;
  double radius = 0.0;  ///< [mm]
};

/// A tree of boxes around a mesh's triangles, for those that a plane may cut near a place.
class TriangleBlocks {
 public:
  explicit TriangleBlocks(const TriangleMesh& mesh);

  /// Some triangles, among them all that the plane cuts, or comes within 1e-8 mm of, and whose box
  /// reaches into the ball; in no order that means anything.
  [[nodiscard]] std::vector<int> near_cut(const Plane& plane, const Ball& ball) const;

 private:
  struct Box {
    Vec3 middle, half;
  };
  void add_near_cut(std::size_t level, std::size_t block, const Plane& plane, const Ball& ball,
                    std::vector<int>& found) const;

  std::vector<int> triangles_;            ///< along a Morton curve
  std::vector<std::vector<Box>> levels_;  ///< around runs of triangles, then around runs of those
};

}  // namespace angio::meshing::detail
