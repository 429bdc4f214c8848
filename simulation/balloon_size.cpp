#include "simulation/balloon_size.hpp"

#include <algorithm>
#include <cmath>

namespace angio::simulation {
namespace {

constexpr double kLeastCoronary = 2.0, kMostCoronary = 4.0;    // diameters [mm]
constexpr double kWallShare = 0.02 / 3.0, kLeastWall = 0.015;  // of the diameter; [mm]
// Pressure [atm] and share of the nominal diameter: sc-3.0 of balloons.toml.
constexpr ChartPoint kGrowthAtPressure[] = {{4.0, 2.85 / 3.0},  {6.0, 2.93 / 3.0},
                                            {8.0, 1.0},         {10.0, 3.06 / 3.0},
                                            {12.0, 3.11 / 3.0}, {14.0, 3.16 / 3.0}};
constexpr double kBySize = -1.0;  // of a film's traction: 0 means that there is none

void fill(double& field, double value) {
  if (field == 0.0) field = value;
}

}  // namespace

BalloonSize balloon_size(double nominal_diameter_mm) {
  const double share = std::sqrt(std::max(1.0, nominal_diameter_mm / kMostCoronary));
  const double wall =
      std::max(kLeastWall, kWallShare * std::min(nominal_diameter_mm, kMostCoronary));
  const BalloonSize coronary;
  BalloonSize size{
      wall * share, coronary.nominal_pressure_atm / share, coronary.rated_burst_atm / share, {}};
  for (const ChartPoint& point : kGrowthAtPressure)
    size.chart.push_back({point.pressure_atm / share, point.diameter_mm * nominal_diameter_mm});
  return size;
}

double contact_scale(double nominal_diameter_mm) {
  return nominal_diameter_mm < kLeastCoronary  ? nominal_diameter_mm / kLeastCoronary
         : nominal_diameter_mm > kMostCoronary ? nominal_diameter_mm / kMostCoronary
                                               : 1.0;
}

SimulationOptions options_by_size() {
  SimulationOptions options;
  options.balloon.wall_mm = 0.0;
  options.inflation.peak_pressure_atm = 0.0;
  options.inflation.rated_burst_atm = 0.0;
  options.contact.distance_mm = 0.0;
  options.contact.adhesion_traction_kpa = kBySize;
  options.contact.adhesion_gap_1_mm = options.contact.adhesion_gap_2_mm = 0.0;
  return options;
}

SimulationOptions sized(SimulationOptions options, double nominal_diameter_mm) {
  const BalloonSize size = balloon_size(nominal_diameter_mm);
  const double scale = contact_scale(nominal_diameter_mm);
  const SimulationOptions coronary;
  fill(options.balloon.wall_mm, size.wall_mm);
  fill(options.inflation.peak_pressure_atm, size.nominal_pressure_atm);
  fill(options.inflation.rated_burst_atm, size.rated_burst_atm);
  fill(options.contact.distance_mm, scale * coronary.contact.distance_mm);
  if (options.contact.adhesion_traction_kpa < 0.0)
    options.contact.adhesion_traction_kpa = coronary.contact.adhesion_traction_kpa / scale;
  fill(options.contact.adhesion_gap_1_mm, scale * coronary.contact.adhesion_gap_1_mm);
  fill(options.contact.adhesion_gap_2_mm, scale * coronary.contact.adhesion_gap_2_mm);
  return options;
}

}  // namespace angio::simulation
