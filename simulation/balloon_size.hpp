#pragma once

#include <vector>

#include "simulation/chart.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation {

/// What a balloon of a nominal diameter is like, from the coronary to the aortic. Representative:
/// no product's figures.
struct BalloonSize {
  double wall_mm = 0.02;              ///< membrane thickness before inflation
  double nominal_pressure_atm = 8.0;  ///< at which it has its nominal diameter
  double rated_burst_atm = 14.0;
  /// What it measures alone, from half the nominal pressure to the rated one.
  std::vector<ChartPoint> chart;
};

/// Up to 4 mm those of the semi-compliant coronary balloons of balloons.toml, by the rules in its
/// head, between its sizes as well: the 3.0 mm chart scaled by the diameter, a wall of 0.020 mm at
/// 3.0 mm in proportion to it, at least 0.015 mm. Above, wall and pressure share what a larger
/// diameter D costs, so that the hoop stress of the thin wall at the rated pressure stays what it
/// is at 4 mm, 106 MPa, and the balloon grows by the same percent from the nominal to the rated
/// pressure:
///
///     sigma = p D / (2 t),   t = t4 sqrt(D / 4 mm),   p = p4 sqrt(4 mm / D)
///
/// At 24 mm: nominal 3.3 atm, rated 5.7 atm. Measured balloons of 20 to 28 mm: nominal 3, rated 6
/// atm (doi 10.1002/ccd.28503); of 15 to 20 mm: at their nominal diameter at 4 atm (Chaufour,
/// White, J Endovasc Surg 5 (1998) 113). Balloon walls are thinner than 0.005 D and hold more than
/// 241 MPa (EP 0274411).
///
/// @param nominal_diameter_mm  > 0
BalloonSize balloon_size(double nominal_diameter_mm);

/// By how much the lengths of contact differ from those of a balloon of 2 to 4 mm, so that they
/// keep their share of its triangles: D / 4 mm above, D / 2 mm below.
double contact_scale(double nominal_diameter_mm);

/// Options that leave to the balloon's size what depends on it: these fields are 0.
SimulationOptions options_by_size();

/// The same options with each field that options_by_size() leaves at 0, and that still is, filled
/// in: the membrane's wall, the peak pressure (nominal) and the rated one, the contact distance,
/// and the adhesive film with its gaps. The film's traction falls as its gaps grow, as capillary
/// pressure does.
SimulationOptions sized(SimulationOptions options, double nominal_diameter_mm);

}  // namespace angio::simulation
