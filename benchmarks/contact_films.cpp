#include <algorithm>
#include <cmath>
#include <vector>

#include "benchmarks/contact_rows.hpp"
#include "testing/simulation/matched.hpp"

namespace angio::simulation {
namespace {

SimulationOptions touch_and_part() {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.backend = Backend::cpu;
  options.inflation.control = InflationControl::pressure;
  options.inflation.peak_pressure_atm = 2.0;
  options.inflation.inflate_s = options.inflation.deflate_s = 0.75;
  options.inflation.hold_s = options.inflation.rest_s = 0.1;
  return options;
}

struct Curves {
  double untouched = 0.0;  ///< the greatest of both before the first touch [mm]
  double friction = 0.0, pressed = 0.0, parting = 0.0, last = 0.0;  ///< [mm]
  double depth = 0.0, widest = 0.0;                                 ///< [mm]
};

Curves curves(const SimulationModel& model, const SimulationOptions& options) {
  Curves c;
  bool touched = false;
  simulate(model, options, [&](const SimulationFrame& f) {
    touched = touched || f.contact.count > 0;
    const double viscous = f.contact.viscous_delta_mm;
    if (!touched) c.untouched = std::max({c.untouched, viscous, f.contact.friction_delta_mm});
    c.friction = std::max(c.friction, f.contact.friction_delta_mm);
    if (f.phase == Phase::hold) c.pressed = viscous;
    if (f.phase == Phase::deflate) c.parting = std::max(c.parting, viscous);
    c.last = viscous;
    c.depth = std::max(c.depth, f.contact.max_penetration_mm);
    c.widest = std::max(c.widest, f.balloon_diameter_mm);
  });
  return c;
}

// Nothing here is asked of the paper's contact: the numbers show what it is.

}  // namespace

Rows adhesion() {
  const SimulationModel model = testing::matched_model(0.5, 0.62);
  const Curves c = curves(model, touch_and_part());
  SimulationOptions strong = touch_and_part();
  strong.contact.adhesion_traction_kpa = 25.0;
  const Curves s = curves(model, strong);
  const Curves near = curves(testing::matched_model(0.565, 0.62), touch_and_part());
  return {{"film: pull before the first touch", c.untouched, 0.0, "mm"},
          {"film: pull while pressed, over that while they part", c.pressed / c.parting, 0.5, ""},
          {"film: pull at the end, over the greatest", c.last / c.parting, 0.5, ""},
          {"film, balloon that stays near: pull at the end", near.last, 1e-4, "mm", true},
          {"film x 10: pull while they part, over film x 1", s.parting / c.parting, 2.0, "", true}};
}

Rows paper() {
  const SimulationModel model = testing::matched_model(0.5, 0.62);
  SimulationOptions options = touch_and_part();
  options.contact.model = ContactModel::paper;
  const Curves c = curves(model, options);
  options.sweeps = 80;
  const Curves more = curves(model, options);
  return {{"paper: deepest crossing (no bar)", 1e3 * c.depth, 0.0, "um", true},
          {"paper: friction with sweeps x 4, over sweeps x 1 (no bar)", more.friction / c.friction,
           0.0, "", true},
          {"paper: viscous, while they part (no bar)", c.parting, 0.0, "mm", true},
          {"paper: viscous, sweeps x 4 over sweeps x 1 (no bar)", more.parting / c.parting, 0.0, "",
           true}};
}

}  // namespace angio::simulation
