#pragma once

#include <vector>

#include "simulation/detail/scene.hpp"
#include "simulation/detail/step_state.hpp"

namespace angio::simulation::detail {

/// A pair as it is found.
struct ContactPair : NearPair<double> {
  double limit[4]{};  ///< how far each vertex may go against its side of the normal [mm]
};

/// All pairs within reach of each other, and for each vertex the pairs it is in.
struct ContactSet {
  std::vector<ContactPair> pairs;
  std::vector<int> ref_begin;  ///< shape [vertex_count + 1]
  std::vector<ContactRef> refs;
  std::vector<int> bound_begin;             ///< shape [vertex_count + 1]
  std::vector<MotionBound<double>> bounds;  ///< those that bind before `travel` does
  double travel = 0.0;  ///< how far any vertex may go before the next detection [mm]
};

/// Finds every vertex-triangle and edge-edge pair of balloon and wall nearer than `reach`.
///
/// Each vertex of a pair gets an a-priori bound: side a must stay beyond, and side b before, planes
/// across the gap 0.1 d apart, so that no motion within the bounds can make the pair cross; pairs
/// that are not listed are safe as long as no vertex moves further than `travel`
/// <= (reach - contact distance) / 2. Source: Chen et al., "Offset Geometric Contact", ACM TOG 44
/// (2025), section 3.4 (bounds by 0.45 of the distance); here with a plane across the gap instead
/// of a ball, so that sliding and parting are free.
///
/// The order of the pairs does not depend on the number of threads.
///
/// @param x     [mm], shape [vertex]
/// @param area  of each vertex [mm^2], shape [vertex]
ContactSet find_contacts(const Scene& scene, const std::vector<Vec3>& x,
                         const std::vector<double>& area, double reach, double travel);

}  // namespace angio::simulation::detail
