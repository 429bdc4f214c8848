#include "core/error.hpp"
#include "core/require.hpp"
#include "simulation/materials/material.hpp"
#include "simulation/pbd/policy.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation {

using namespace detail;

void GuidewireOptions::validate() const {
  require_within("guidewire.shaft_diameter_mm", shaft_diameter_mm, 0.2, 10.0);
  require_within("guidewire.shaft_modulus_mpa", shaft_modulus_mpa, 1.0, 1e6);
  require_within("guidewire.wire_diameter_mm", wire_diameter_mm, 0.05, 0.95 * shaft_diameter_mm);
  require_within("guidewire.wire_modulus_mpa", wire_modulus_mpa, 0.0, 1e6);
  require_within("guidewire.density_g_mm3", density_g_mm3, 1e-5, 0.1);
}

void SimulationOptions::validate() const {
  if (!is_named_material(balloon.name) && !(balloon.c1_mpa > 0.0))
    throw OptionError("balloon.material is \"" + balloon.name +
                      "\" (unknown material). Use pa12, pet or polyurethane, or give c1_mpa and "
                      "c2_mpa");
  if (!balloon.chart.empty()) validate_chart(balloon.chart, balloon.name);
  require_within("balloon.c1_mpa", balloon.c1_mpa, 0.0, 1e6);
  require_within("balloon.c2_mpa", balloon.c2_mpa, 0.0, 1e6);
  require_within("balloon.wall_mm", balloon.wall_mm, 0.001, 1.0);
  require_within("balloon.density_g_mm3", balloon.density_g_mm3, 0.0, 1.0);
  require_within("wall.shape_beta", wall.shape_beta, 0.0, 1.0);
  require_within("wall.modulus_kpa", wall.modulus_kpa, 1.0, 1e6);
  require_within("wall.thickness_ratio", wall.thickness_ratio, 1e-6, 0.45);
  require_within("wall.yield_strain", wall.yield_strain, 0.0, 10.0);
  require_within("wall.creep_per_s", wall.creep_per_s, 0.0, 1000.0);
  require_within("wall.max_plastic_strain", wall.max_plastic_strain, 0.0, 10.0);
  require_within("wall.foundation_kpa_per_mm", wall.foundation_kpa_per_mm, 0.0, 1e5);
  require_within("wall.density_g_mm3", wall.density_g_mm3, 0.0, 1.0);
  layered_wall.validate();
  require_within("inflation.inflate_s", inflation.inflate_s, 1e-6, 600.0);
  require_within("inflation.hold_s", inflation.hold_s, 0.0, 600.0);
  require_within("inflation.deflate_s", inflation.deflate_s, 1e-6, 600.0);
  require_within("inflation.rest_s", inflation.rest_s, 0.0, 600.0);
  require_within("inflation.peak_pressure_atm", inflation.peak_pressure_atm, 1e-6, 40.0);
  require_within("inflation.rated_burst_atm", inflation.rated_burst_atm, 0.0, 100.0);
  require_within("inflation.outside_pressure_kpa", inflation.outside_pressure_kpa, 0.0, 50.0);
  require_within("inflation.deflate_pressure_atm", inflation.deflate_pressure_atm, -1.0, 0.0);
  require_within("inflation.peak_volume_mm3", inflation.peak_volume_mm3, 0.0, 1e6);
  validate_pbd(*this);
  if (guidewire.model == GuidewireModel::rod) guidewire.validate();
  require_within("simulation.frame_s", frame_s, 1e-4, 1.0);
  require_within("simulation.tolerance", tolerance, 1e-6, 0.1);
  require_within("simulation.sweeps", double(sweeps), 0.0, 1000.0);
  require_within("simulation.contact_distance_mm", contact.distance_mm, 1e-3, 1.0);
  require_within("simulation.contact_stiffness", contact.stiffness, 0.01, 100.0);
  require_within("simulation.friction_static", contact.friction_static, 0.0, 2.0);
  require_within("simulation.friction_kinetic", contact.friction_kinetic, 0.0, 2.0);
  require_within("simulation.adhesion_traction_kpa", contact.adhesion_traction_kpa, 0.0, 100.0);
  require_within("simulation.adhesion_gap_1_mm", contact.adhesion_gap_1_mm, 0.0, 1.0);
  require_within("simulation.paper_volume_1_mm3", contact.paper_volume_1_mm3, 0.0, 100.0);
  require_within("simulation.paper_volume_2_mm3", contact.paper_volume_2_mm3, 0.0, 100.0);
  require_within("simulation.adhesion_gap_2_mm", contact.adhesion_gap_2_mm,
                 contact.adhesion_gap_1_mm + 1e-3, 2.0);
}

}  // namespace angio::simulation
