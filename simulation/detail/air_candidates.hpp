#pragma once

#include "simulation/detail/adaptive_air.hpp"
#include "simulation/detail/candidates.hpp"

namespace angio::simulation::detail {

/// Every vertex-triangle and edge-edge pair of balloon and wall nearer than `reach` that face each
/// other through the air: the primitives that a walk from a balloon's triangle through the tets
/// within reach of it meets.
///
/// It is complete: the shortest way between two primitives either runs through the air, and then
/// through tets that the walk takes one after the other, or meets a surface on the way, and then
/// that one is what must not be passed. Where the surfaces have moved on since the air followed
/// them, by m at most, that way, carried back with the air, was within m of where it is now: the
/// walk reaches m further. A pair that only a surface parts is left out where the walk does not
/// come round it.
///
/// @param air  whole; where the surfaces were a while ago
/// @param x    [mm], shape [vertex]
std::vector<Candidate> find_candidates_in_air(const AdaptiveAir& air, const Scene& scene,
                                              const std::vector<Vec3>& x, double reach);

}  // namespace angio::simulation::detail
