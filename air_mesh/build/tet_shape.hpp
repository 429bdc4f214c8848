#pragma once

#include <array>

#include "core/tet_mesh.hpp"

namespace angio::air_mesh {

/// Faces of a right-handed tetrahedron, counter-clockwise seen from outside; face i lacks corner i.
constexpr int kTetFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

/// Least sine of a tetrahedron's six dihedral angles, negative if it is turned over: it falls
/// towards 0 both for sharp and for blunt angles.
double least_dihedral_sine(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Smallest and largest dihedral angle of a tetrahedron [degrees].
struct DihedralRange {
  double least = 180.0;
  double greatest = 0.0;
};
DihedralRange dihedral_range(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace angio::air_mesh
