#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "simulation/materials/gas.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// Absolute pressure around the balloon [Pa]: one atmosphere and the blood.
double outside_pressure(const SimulationOptions& options);

/// What the inflator does, frame by frame; see docs/method/simulation.md. Plain numbers, so that a
/// GPU can go through the frames by itself.
class Inflator {
 public:
  Inflator() = default;
  /// @param start_volume    [mm^3] of the start shape
  /// @param nominal_volume  [mm^3] that the balloon is expected to fill
  Inflator(const SimulationOptions& options, double start_volume, double nominal_volume);

  [[nodiscard]] int frame_count() const { return rest_end_ + 1; }
  [[nodiscard]] ANGIO_HOST_DEVICE Phase phase(int frame) const {
    if (frame <= insert_end_) return Phase::insert;
    if (frame <= inflate_end_) return Phase::inflate;
    if (frame <= hold_end_) return Phase::hold;
    if (frame <= deflate_end_) return Phase::deflate;
    return Phase::rest;
  }

  /// The law during the step that ends at `frame`, from the gas Q = p V [Pa mm^3] and the volume V
  /// [mm^3] before it. To be called for one frame after the other.
  [[nodiscard]] ANGIO_HOST_DEVICE GasLaw<double> law(int frame, double gas, double volume) {
    GasLaw<double> law;
    law.limit = law.top = kNoLimit;
    if (frame <= insert_end_)  // open to the outside
      law.slope_pressure = outside_;
    else if (control_ == InflationControl::gas)
      law = gas_law(frame, gas, volume);
    else if (control_ == InflationControl::pressure)
      law = pressure_law(frame, gas);
    else
      law = volume_law(frame, gas, volume);
    gas_before_ = gas;
    volume_before_ = volume;
    return law;
  }

 private:
  // A number that no pressure or amount of gas reaches, and whose products fit in a float.
  static constexpr double kNoLimit = 1e30;
  // The inflator's greatest rate over the rate that fills the nominal volume in time.
  static constexpr double kGreatestRate = 3.0;
  // The most that the volume is expected to grow yet, over what it is.
  static constexpr double kGreatestGrowth = 1.5;

  ANGIO_HOST_DEVICE static double larger(double a, double b) { return a > b ? a : b; }
  ANGIO_HOST_DEVICE static double smaller(double a, double b) { return a < b ? a : b; }

  // How far the phase is that holds the frame, (0, 1] at its last frame.
  ANGIO_HOST_DEVICE double inflated(int frame) const {
    return smaller(1.0, double(frame - insert_end_) / double(inflate_end_ - insert_end_));
  }
  ANGIO_HOST_DEVICE double deflated(int frame) const {
    return larger(0.0, smaller(1.0, double(frame - hold_end_) / double(deflate_end_ - hold_end_)));
  }

  // The volume at the peak pressure: the nominal one until it is reached; then the line through the
  // last two states, V = volume + c (Q - gas), met with Q = peak V.
  ANGIO_HOST_DEVICE double expected_volume(double gas, double volume) const {
    if (volume < volume_nominal_ || !(gas > gas_before_)) return larger(volume, volume_nominal_);
    const double c = (volume - volume_before_) / (gas - gas_before_);
    const double left = 1.0 - peak_ * c, most = kGreatestGrowth * volume;
    return left > 0.0 ? smaller(larger((volume - c * gas) / left, volume), most) : most;
  }

  ANGIO_HOST_DEVICE double most_gas(double gas) const {
    return gas + kGreatestRate * peak_ * volume_nominal_ / double(inflate_end_ - insert_end_);
  }

  ANGIO_HOST_DEVICE GasLaw<double> gas_law(int frame, double gas, double volume) {
    GasLaw<double> law;
    law.limit = law.top = kNoLimit;
    if (frame <= inflate_end_) {
      const int left = inflate_end_ - frame + 1;
      law.lower = gas + (peak_ * expected_volume(gas, volume) - gas) / double(left);
      law.slope_pressure = left == 1 ? peak_ : 0.0;
      law.limit = most_gas(gas);
      law.top = peak_;
      gas_held_ = 0.0;
      return law;
    }
    if (gas_held_ == 0.0) gas_held_ = gas;  // no gas moves from here
    law.lower = gas_held_;
    if (frame > hold_end_) law.lower *= std::pow(gas_end_ / gas_held_, deflated(frame));
    return law;
  }

  // A ramp of the pressure above the outside. Gas flows in no faster than the greatest rate, so
  // that a balloon past its limit point grows steadily; and that of the start shape stays, whatever
  // the vacuum: folds lie on each other.
  ANGIO_HOST_DEVICE GasLaw<double> pressure_law(int frame, double gas) const {
    GasLaw<double> law;
    law.limit = most_gas(gas);
    law.top = kNoLimit;
    const double gauge = peak_ - outside_;
    const double down = deflated(frame);
    law.slope_pressure =
        outside_ + (frame <= hold_end_ ? inflated(frame) * gauge
                                       : (1.0 - down) * gauge + down * deflate_gauge_);
    law.lower = smaller(gas_end_, gas);
    return law;
  }

  // A ramp of the volume. The multiplier begins at the last pressure.
  ANGIO_HOST_DEVICE GasLaw<double> volume_law(int frame, double gas, double volume) const {
    GasLaw<double> law;
    law.limit = law.top = kNoLimit;
    const double share = frame <= hold_end_ ? inflated(frame) : 1.0 - deflated(frame);
    law.volume = volume_start_ + share * (volume_peak_ - volume_start_);
    law.slope_pressure = gas / volume;
    return law;
  }

  InflationControl control_ = InflationControl::gas;
  double outside_ = 0.0, peak_ = 0.0, deflate_gauge_ = 0.0, gas_end_ = 0.0;
  double volume_start_ = 0.0, volume_nominal_ = 0.0, volume_peak_ = 0.0;
  double gas_before_ = 0.0, volume_before_ = 0.0, gas_held_ = 0.0;
  int insert_end_ = 0, inflate_end_ = 0, hold_end_ = 0, deflate_end_ = 0, rest_end_ = 0;
};

}  // namespace angio::simulation::detail
