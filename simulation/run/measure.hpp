#pragma once

#include <vector>

#include "simulation/backends/step_solver.hpp"
#include "simulation/bodies/scene.hpp"

/// What a frame reports of the state.
namespace angio::simulation::detail {

/// How deep balloon and wall are in each other [mm], measured on the triangles: 0 when no two
/// triangles cross; else the greatest depth, over crossing pairs, by which one must be moved along
/// the other's normal to part them.
double max_penetration(const Scene& scene, const std::vector<Vec3>& x);

/// Pairs of triangles of a surface that share no vertex and cross.
int self_crossing_count(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x);

/// Of the wall, a third of each triangle for each corner under contact pressure [mm^2].
double contact_area(const Scene& scene, const State& state);

struct MembraneState {
  std::vector<double> thickness, stretch_1, stretch_2;  ///< per balloon vertex, area-weighted
};
MembraneState membrane_state(const Scene& scene, const std::vector<Vec3>& x);

/// |S^p - I|_2 of the slabs of each wall vertex, their mean.
std::vector<double> plastic_strain(const Scene& scene, const State& state);

/// Stress and strain of a layered wall's wedges.
std::vector<WallStress> solid_stresses(const Scene& scene, const State& state);

}  // namespace angio::simulation::detail
