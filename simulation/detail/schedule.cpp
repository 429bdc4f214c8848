#include "simulation/detail/schedule.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace angio::simulation::detail {
namespace {

constexpr double kNoLimit = 1e300;
// The inflator's greatest rate over the rate that fills the nominal volume in time.
constexpr double kGreatestRate = 3.0;
// The most that the volume is expected to grow yet, over what it is.
constexpr double kGreatestGrowth = 1.5;

int frames(double seconds, double frame_s) { return int(std::lround(seconds / frame_s)); }

}  // namespace

double outside_pressure(const SimulationOptions& options) {
  return units::kPascalPerAtm +
         units::pascal_from_kilopascal(options.inflation.outside_pressure_kpa);
}

Inflator::Inflator(const SimulationOptions& options, double start_volume, double nominal_volume)
    : frame_s_(options.frame_s),
      outside_(outside_pressure(options)),
      peak_(outside_ + units::pascal_from_atm(options.inflation.peak_pressure_atm)),
      gas_end_(outside_ * start_volume),
      volume_nominal_(nominal_volume),
      insert_end_(1),
      inflate_end_(insert_end_ + std::max(1, frames(options.inflation.inflate_s, frame_s_))),
      hold_end_(inflate_end_ + frames(options.inflation.hold_s, frame_s_)),
      deflate_end_(hold_end_ + std::max(1, frames(options.inflation.deflate_s, frame_s_))),
      rest_end_(deflate_end_ + frames(options.inflation.rest_s, frame_s_)) {}

Phase Inflator::phase(int frame) const {
  if (frame <= insert_end_) return Phase::insert;
  if (frame <= inflate_end_) return Phase::inflate;
  if (frame <= hold_end_) return Phase::hold;
  if (frame <= deflate_end_) return Phase::deflate;
  return Phase::rest;
}

// The volume at the peak pressure: the nominal one until it is reached; then the line through the
// last two states, V = volume + c (Q - gas), met with Q = peak V.
double Inflator::expected_volume(double gas, double volume) const {
  if (volume < volume_nominal_ || !(gas > gas_before_)) return std::max(volume, volume_nominal_);
  const double c = (volume - volume_before_) / (gas - gas_before_);
  const double left = 1.0 - peak_ * c;
  const double most = kGreatestGrowth * volume;
  return left > 0.0 ? std::clamp((volume - c * gas) / left, volume, most) : most;
}

GasLaw<double> Inflator::inflate(int frame, double gas, double volume) const {
  GasLaw<double> law;
  const int left = inflate_end_ - frame + 1;
  law.lower = gas + (peak_ * expected_volume(gas, volume) - gas) / double(left);
  law.slope_pressure = left == 1 ? peak_ : 0.0;
  law.limit = gas + kGreatestRate * peak_ * volume_nominal_ / double(inflate_end_ - insert_end_);
  law.top = peak_;
  return law;
}

GasLaw<double> Inflator::law(int frame, double gas, double volume) {
  GasLaw<double> law;
  law.limit = kNoLimit;
  law.top = kNoLimit;
  switch (phase(frame)) {
    case Phase::insert:  // open to the outside
      law.slope_pressure = outside_;
      break;
    case Phase::inflate:
      law = inflate(frame, gas, volume);
      break;
    case Phase::hold:
      law.lower = gas_held_ = phase(frame - 1) == Phase::hold ? gas_held_ : gas;
      break;
    case Phase::deflate: {
      if (phase(frame - 1) == Phase::inflate) gas_held_ = gas;
      const double share = double(frame - hold_end_) / double(deflate_end_ - hold_end_);
      law.lower = gas_held_ * std::pow(gas_end_ / gas_held_, share);
      break;
    }
    case Phase::rest:
      law.lower = gas_end_;
      break;
  }
  gas_before_ = gas;
  volume_before_ = volume;
  return law;
}

}  // namespace angio::simulation::detail
