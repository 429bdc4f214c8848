#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::simulation {

enum class ClothSolver {
  newton,  ///< to 1e-9 of the force balance, in double precision
  vbd,     ///< vertex block descent, in single precision
};

/// The seed paper's section 6.1: a square cloth pulled at its four corners.
struct ClothOptions {
  double side_mm = 6000.0;
  double thickness_mm = 1.0;
  int cells = 50;  ///< a side, even, [2, 1000]: (cells + 1)^2 vertices, 2 cells^2 triangles
  double c1_mpa = 1.031, c2_mpa = 3.69;  ///< Mooney-Rivlin (seed paper, table 1, in MPa)
  double stretch = 0.35;  ///< the corners' distance grows by this share in the end, (0, 3]
  int steps = 20;         ///< in which it is pulled, [1, 10000]
  ClothSolver solver = ClothSolver::newton;
};

struct ClothState {
  double stretch = 0.0;              ///< of the corners' distance, as a share
  std::vector<Vec3> positions;       ///< [mm], shape [vertex]
  std::vector<double> thickness_mm;  ///< h = H / sqrt(I3) (seed paper, Eq. 6), shape [triangle]
  double residual = 0.0;             ///< of the force balance, relative, in double precision
  int iterations = 0;                ///< Newton's, or sweeps over all vertices
  bool converged = false;
};

struct Cloth {
  TriangleMesh rest;
  std::vector<ClothState> states;  ///< the start, then one after each step
};

/// The cloth before it is pulled; only its side and cells count. @throws OptionError
TriangleMesh cloth_mesh(const ClothOptions& options);

/// The equilibrium in the plane after each step. The cells' diagonals alternate, so that the mesh
/// has the square's eight symmetries.
/// @throws OptionError
Cloth pull_cloth(const ClothOptions& options);

}  // namespace angio::simulation
