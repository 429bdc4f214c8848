#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// The wall cut into overlapping slabs across the vessel, each matched to its shape as a whole.
/// A slab vertex is a (slab, vertex) pair; they are stored by slab, and every vertex has at least
/// one.
struct WallSlabs {
  std::vector<int> begin;         ///< slab vertices of a slab, shape [slab_count + 1]
  std::vector<int> vertex;        ///< wall vertex, shape [slab vertex]
  std::vector<double> stiffness;  ///< k [uN/mm], shape [slab vertex]
  std::vector<Vec3> offset;       ///< q: start position from the slab's centre [mm]
  std::vector<double> modes;      ///< phi [mm], shape [slab vertex][kShapeModes]; empty: linear
  std::vector<double> radius;     ///< local radius of the slab [mm], shape [slab_count]
  std::vector<Vec3> axis;         ///< unit, along the vessel
  std::vector<double> along;      ///< what a slab's stiffness along its axis adds to `stiffness`,
                                  ///< as a multiple; 0: not a ring. Shape [slab_count]
  std::vector<char> ring;         ///< the slab closes around the vessel
  std::vector<int> slab_vertex_begin;  ///< slab vertices of a wall vertex, shape [wall_count + 1]
  std::vector<int> slab_vertices;      ///< their numbers, ascending in slab
  std::vector<int> slab_of;            ///< slab of a slab vertex, shape [slab vertex]

  [[nodiscard]] int count() const { return int(begin.size()) - 1; }
};

/// Slabs one local radius long, half overlapping, along the abscissa of each group; a slab is a
/// connected piece, widened by one ring of neighbours so that slabs hold together across the border
/// of two groups.
///
///     k_i = E t A_i / r^2, divided over the slabs of vertex i,   t = 2 r a / (1 - 2 a)
///
/// The divisor falls from the middle of a slab to its ends (a hat function), so that neighbouring
/// slabs pass into each other without a step,
/// so that a tube widened evenly by dr carries the pressure E t dr / r^2 of a thin elastic ring (a:
/// wall thickness / outer diameter).
///
/// Slabs on their own would let each other pass along the vessel (a chain of them has a twenty-
/// fourth of a tube's modulus), and know nothing of the plaque behind a narrow lumen. A ring has so
/// much more stiffness along its axis that an even strain e along the vessel costs
///
///     1/2 M d e^2 per area of the lumen,   d = t + (R^2 - r^2) / (2 r)
///     along = M d / (E t / r^2 <(q . a)^2>),   M = E (1 - nu) / ((1 + nu) (1 - 2 nu))
///
/// with d the section of wall and plaque per circumference (R: the healthy vessel's radius) and M
/// the modulus of what cannot give way sideways: tissue between the shoulders of a balloon has the
/// balloon inside and the vessel outside.
WallSlabs make_slabs(const SimulationModel& model, const WallMaterial& material);

}  // namespace angio::simulation::detail
