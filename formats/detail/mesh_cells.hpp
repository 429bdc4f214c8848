#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::formats::detail {

/// A cell of a mesh, by its corners, which come first and in Gmsh's order (that of Medit, too); the
/// nodes of a cell of higher order that follow them do not count.
enum class CellShape { triangle, quadrilateral, tetrahedron, pyramid, prism, hexahedron };

std::size_t corner_count(CellShape shape);

/// The surface of a mesh of cells: the faces that belong to one solid cell only or, where no cell
/// is solid, the flat cells. A cell that stands there twice, as of two groups of Gmsh's, counts
/// once.
class CellSurface {
 public:
  /// @param nodes  indices of points, corner_count(shape) or more
  void add(CellShape shape, std::span<const int> nodes);

  /// With those of the points that a face uses, in their order. Quadrilaterals are cut in two.
  [[nodiscard]] TriangleMesh over(const std::vector<Vec3>& points) const;

 private:
  using Face = std::array<int, 4>;  ///< outwards, counter-clockwise; the last is -1 in a triangle
  struct Cell {
    std::vector<int> sorted;  ///< its corners, which tell it from others
    CellShape shape;
    std::size_t first;  ///< of its corners in corners_
  };
  [[nodiscard]] std::vector<Face> faces() const;

  std::vector<int> corners_;
  std::vector<Cell> cells_;
};

}  // namespace angio::formats::detail
