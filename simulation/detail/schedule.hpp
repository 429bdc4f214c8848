#pragma once

#include "simulation/detail/gas.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// Absolute pressure around the balloon [Pa]: one atmosphere and the blood.
double outside_pressure(const SimulationOptions& options);

/// What the inflator does, frame by frame; see README.md, "The gas".
class Inflator {
 public:
  /// @param start_volume    [mm^3] of the start shape
  /// @param nominal_volume  [mm^3] that the balloon is expected to fill
  Inflator(const SimulationOptions& options, double start_volume, double nominal_volume);

  [[nodiscard]] int frame_count() const { return rest_end_ + 1; }
  [[nodiscard]] Phase phase(int frame) const;
  /// The law during the step that ends at `frame`, from the gas Q = p V [Pa mm^3] and the volume V
  /// [mm^3] before it. To be called for one frame after the other.
  [[nodiscard]] GasLaw<double> law(int frame, double gas, double volume);

 private:
  [[nodiscard]] double expected_volume(double gas, double volume) const;
  [[nodiscard]] GasLaw<double> inflate(int frame, double gas, double volume) const;

  double frame_s_, outside_, peak_, gas_end_, volume_nominal_;
  double gas_before_ = 0.0, volume_before_ = 0.0, gas_held_ = 0.0;
  int insert_end_, inflate_end_, hold_end_, deflate_end_, rest_end_;
};

}  // namespace angio::simulation::detail
