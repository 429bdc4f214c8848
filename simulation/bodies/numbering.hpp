#pragma once

#include <array>
#include <vector>

#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// An order of a surface's vertices in which each colour is one run, and neighbours lie near each
/// other within it. No two vertices of a colour share an edge, hence no term of the energy within
/// their surface; vertices that do not move come last, without a colour.
struct Numbering {
  std::vector<int> order;  ///< the caller's vertex, shape [vertex]
  std::vector<int> begin;  ///< first vertex of a colour in the new order, shape [color_count + 1]
};

/// Colours by largest saturation first (Brelaz, CACM 22 (1979)): a triangulation that has a
/// 3-colouring, as every one whose inner vertices have an even number of triangles, gets one.
/// Within a colour, in breadth-first order from the surface's first vertex.
///
/// @param partners  further pairs of vertices that may not share a colour
Numbering number_vertices(const TriangleMesh& mesh, const std::vector<char>& fixed,
                          const std::vector<std::array<int, 2>>& partners = {});

/// The model with its balloon and wall vertices in the given orders.
SimulationModel renumbered(const SimulationModel& model, const Numbering& balloon,
                           const Numbering& wall);

}  // namespace angio::simulation::detail
