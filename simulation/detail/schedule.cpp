#include "simulation/detail/schedule.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace angio::simulation::detail {
namespace {

constexpr double kNoLimit = 1e300;
// The inflator's greatest rate over the rate that fills the nominal volume in time.
constexpr double kGreatestRate = 3.0;

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
      gas_nominal_(peak_ * nominal_volume),
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

GasLaw<double> Inflator::law(int frame, double gas_before) const {
  GasLaw<double> law;
  law.limit = kNoLimit;
  law.top = peak_;
  switch (phase(frame)) {
    case Phase::insert:  // open to the outside
      law.slope_pressure = outside_;
      break;
    case Phase::inflate: {
      const double share = 1.0 / double(inflate_end_ - frame + 1);
      law.slope_gas = (1.0 - share) * gas_before;
      law.slope_pressure = share * peak_;
      law.lower = law.slope_gas + share * gas_nominal_;
      law.limit = gas_before +
                  kGreatestRate * (gas_nominal_ - gas_end_) / double(inflate_end_ - insert_end_);
      break;
    }
    case Phase::hold:
      law.lower = gas_before;
      break;
    case Phase::deflate: {
      const double share = double(frame - hold_end_) / double(deflate_end_ - hold_end_);
      law.lower = gas_peak_ * std::pow(gas_end_ / gas_peak_, share);
      break;
    }
    case Phase::rest:
      law.lower = gas_end_;
      break;
  }
  return law;
}

}  // namespace angio::simulation::detail
