#include "simulation/run/schedule.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace angio::simulation::detail {
namespace {

int frames(double seconds, double frame_s) { return int(std::lround(seconds / frame_s)); }

}  // namespace

double outside_pressure(const SimulationOptions& options) {
  return units::kPascalPerAtm +
         units::pascal_from_kilopascal(options.inflation.outside_pressure_kpa);
}

Inflator::Inflator(const SimulationOptions& options, double start_volume, double nominal_volume)
    : control_(options.inflation.control),
      outside_(outside_pressure(options)),
      peak_(outside_ + units::pascal_from_atm(options.inflation.peak_pressure_atm)),
      deflate_gauge_(units::pascal_from_atm(options.inflation.deflate_pressure_atm)),
      gas_end_(outside_ * start_volume),
      volume_start_(start_volume),
      volume_nominal_(nominal_volume),
      volume_peak_(options.inflation.peak_volume_mm3 > 0.0 ? options.inflation.peak_volume_mm3
                                                           : nominal_volume) {
  const InflationSchedule& s = options.inflation;
  insert_end_ = 1;
  inflate_end_ = insert_end_ + std::max(1, frames(s.inflate_s, options.frame_s));
  hold_end_ = inflate_end_ + frames(s.hold_s, options.frame_s);
  deflate_end_ = hold_end_ + std::max(1, frames(s.deflate_s, options.frame_s));
  rest_end_ = deflate_end_ + frames(s.rest_s, options.frame_s);
}

}  // namespace angio::simulation::detail
