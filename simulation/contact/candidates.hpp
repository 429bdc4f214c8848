#pragma once

#include <vector>

#include "simulation/bodies/scene.hpp"
#include "simulation/step/views.hpp"

/// The wide level of contact: which primitives of balloon and wall face each other; see
/// near_pairs.hpp for what the step makes of them.
namespace angio::simulation::detail {

/// Every vertex-triangle and edge-edge pair of balloon and wall nearer than `radius`, with their
/// gaps; in no order.
///
/// @param x  [mm], shape [vertex]
std::vector<Candidate> find_candidates(const Scene& scene, const std::vector<Vec3>& x,
                                       double radius);

/// Adds every pair of the balloon and the guidewire's shaft nearer than `radius`: vertices and
/// edges of the balloon against segments, triangles against nodes; in no order.
///
/// @param x                 [mm], shape [vertex]
/// @param contact_distance  what starts nearer than this to the shaft is no pair
void add_rod_candidates(const Scene& scene, const std::vector<Vec3>& x, double contact_distance,
                        double radius, std::vector<Candidate>& candidates);

/// Adds every pair of the balloon and itself nearer than `radius` that can come nearer or part:
/// they share no vertex, and not all of theirs are fixed. In no order.
///
/// @param x  [mm], shape [vertex]
void add_balloon_self_candidates(const Scene& scene, const std::vector<Vec3>& x, double radius,
                                 std::vector<Candidate>& candidates);

/// The same of the wall and itself.
void add_wall_self_candidates(const Scene& scene, const std::vector<Vec3>& x, double radius,
                              std::vector<Candidate>& candidates);

/// Has a closed surface layers nearer than `within` whose normals are opposed?
bool has_facing_layers(const TriangleMesh& membrane, double within);

/// Distance of a candidate's two primitives, less its radius [mm].
double gap_of(const std::vector<Vec3>& x, const Candidate& candidate);

/// Sets a candidate's gap if it is less than `radius`. @return is it?
bool is_near(const std::vector<Vec3>& x, double radius, Candidate& candidate);

}  // namespace angio::simulation::detail
