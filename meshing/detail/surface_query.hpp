#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing::detail {

/// Pairs of triangles, one of them marked, that share an edge and all but fold onto each other:
/// less than 35 degrees between them, on either side. What lies between cannot be filled with sound
/// tetrahedra.
std::vector<std::array<int, 2>> sharp_folds_of(const TriangleMesh& mesh,
                                               const std::vector<char>& marked);

/// Triangles spread evenly over the area [unit of the coordinates squared].
std::vector<std::size_t> samples_of(const TriangleMesh& mesh, double area, int count);

/// Triangles spread evenly over the area [unit of the coordinates squared].
std::vector<std::size_t> samples_of(const TriangleMesh& mesh, double area, int count);

/// The nearest point of a surface, and the next one along a ray.
class ClosestPoint {
 public:
  struct Result {
    Vec3 point;
    int triangle = 0;
    double distance = 0.0;
  };
  explicit ClosestPoint(const TriangleMesh& mesh);
  ~ClosestPoint();
  ClosestPoint(const ClosestPoint&) = delete;
  ClosestPoint& operator=(const ClosestPoint&) = delete;
  [[nodiscard]] Result find(const Vec3& point) const;
  /// How far a ray runs from a point of one triangle until it meets another; infinity if it meets
  /// none.
  [[nodiscard]] double ahead(const Vec3& from, const Vec3& direction, int own_triangle) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace angio::meshing::detail
