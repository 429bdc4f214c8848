#pragma once

#include <vector>

#include "simulation/bodies/scene.hpp"
#include "simulation/step/convert.hpp"
#include "simulation/step/state_view.hpp"
#include "simulation/step/status.hpp"

namespace angio::simulation::detail {

/// What a frame ends with, in the scene's numbering.
struct State {
  std::vector<Vec3> x;                           ///< [mm], shape [vertex]
  std::vector<Mat3> plastic;                     ///< S^p of the slabs
  std::vector<Vec3> plastic_modes;               ///< N^p, shape [slab][kShapeModes]; or empty
  std::vector<double> contact_pressure;          ///< [Pa], shape [wall vertex]
  std::vector<SolidPoint<double>> solid_points;  ///< of a layered wall, with what has flowed
  std::vector<double> solid_plastic_strain;      ///< gathered there
  double pressure = 0.0;                         ///< absolute [Pa]
  double volume = 0.0;                           ///< enclosed [mm^3]
  StepReport report;
};

State start_state(const Scene& scene, double pressure);

/// Enclosed volume of the balloon [mm^3].
double balloon_volume(const Scene& scene, const std::vector<Vec3>& x);

/// The state that a step has left.
///
/// @param start  the scene's start as the step has it
/// @param end    in the computer's memory
template <class Real>
State make_state(const Scene& scene, const Vec3T<Real>* start, const StateView<Real>& end,
                 const StepStatus& status) {
  const auto copied = [](const auto& values, auto& to, const auto& convert) {
    to.reserve(std::size_t(values.count));
    for (int i = 0; i < values.count; ++i) to.push_back(convert(values.data[i]));
  };
  const auto to_double = [](const auto& value) { return converted<double>(value); };
  const auto number = [](Real value) { return double(value); };
  State state;
  state.x = global(scene, start, end.x.data);
  copied(end.plastic, state.plastic, to_double);
  copied(end.plastic_modes, state.plastic_modes, to_double);
  copied(end.contact_pressure, state.contact_pressure, number);
  copied(end.solid_points, state.solid_points, to_double);
  copied(end.solid_plastic_strain, state.solid_plastic_strain, number);
  state.pressure = status.pressure;
  state.volume = status.volume;
  state.report = status.report;
  return state;
}

}  // namespace angio::simulation::detail
