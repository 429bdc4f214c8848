#pragma once

#include "simulation/step/views.hpp"

namespace angio::simulation::detail {

/// An array of a frame's state, and how many values it has.
template <class Value>
struct StateArray {
  Value* data = nullptr;
  int count = 0;
};

/// What a frame hands out of a step's arrays, on a device or here (see State).
template <class Real>
struct StateView {
  StateArray<Vec3T<Real>> x;
  StateArray<Real> contact_pressure;
  StateArray<Mat3T<Real>> plastic;        ///< [slab]
  StateArray<Vec3T<Real>> plastic_modes;  ///< [slab][kShapeModes]
  StateArray<SolidPoint<Real>> solid_points;
  StateArray<Real> solid_plastic_strain;
};

template <class Real>
ANGIO_HOST_DEVICE inline StateView<Real> state_view(const StepView<Real>& s) {
  const SlabFitView<Real>& fit = s.slabs.fit;
  return {{s.motion.x, s.motion.count},
          {s.wall.contact_pressure, s.wall.mesh.count},
          {fit.plastic, s.slabs.count},
          {fit.plastic_modes, fit.plastic_modes ? s.slabs.count * kShapeModes : 0},
          {s.layered.points, s.layered.point_count()},
          {s.layered.plastic_strain, s.layered.point_count()}};
}

/// Calls visit(array, ...) with the same array of each of the views, one array after the other.
template <class Visit, class... Views>
ANGIO_HOST_DEVICE inline void for_each_state_array(const Visit& visit, Views&... views) {
  visit(views.x...);
  visit(views.contact_pressure...);
  visit(views.plastic...);
  visit(views.plastic_modes...);
  visit(views.solid_points...);
  visit(views.solid_plastic_strain...);
}

}  // namespace angio::simulation::detail
