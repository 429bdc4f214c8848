#pragma once

#include <optional>
#include <vector>

#include "simulation/simulation.hpp"

/// Where, and how hard, the balloon presses the wall.
namespace angio::simulation {

/// What presses the wall, at any mesh. The pressure is the mean over a disc around each vertex,
///
///     p(i) = sum_j w_ij a_j p_j / sum_j w_ij a_j,   w_ij = max(0, 1 - |x_j - x_i| / R),
///
/// over what of the surface is joined to i within R = D / 5, D the balloon's diameter in the
/// lesion; a_j is a third of the triangles at j. Contact is sampled by vertices and its range grows
/// with the edges, so that single pressures, and where they begin, are the mesh's; a mean over a
/// length of the vessel is the vessel's. Pressed is what is under more than a twentieth of the
/// balloon's own pressure.
struct PressedWall {
  std::vector<double> pressure_kpa;  ///< p, shape [wall vertex]
  std::vector<char> is_pressed;      ///< shape [wall vertex]
  double force_n = 0.0;              ///< integral of the pressure over the whole wall
  double area_mm2 = 0.0;             ///< of what is pressed
  double median_kpa = 0.0;           ///< of p by area, over what is pressed; NaN where nothing is
  double p99_kpa = 0.0;              ///< likewise
};

/// @param triangles  of the wall
PressedWall pressed_wall(const std::vector<Triangle>& triangles, const SimulationFrame& frame);

/// The contact pressure of a frame, vertex by vertex, over all that feels any.
struct ContactPressure {
  double median_kpa = 0.0;  ///< by area: each vertex has a third of its triangles
  double p99_kpa = 0.0;
};

/// @param triangles  of the wall
/// @return nothing where the wall is not touched
std::optional<ContactPressure> contact_pressure(const std::vector<Triangle>& triangles,
                                                const SimulationFrame& frame);

}  // namespace angio::simulation
