#pragma once

#include <string>
#include <vector>

namespace angio::simulation {

/// One point of a maker's compliance chart: the balloon alone, held at a pressure.
struct ChartPoint {
  double pressure_atm = 0.0;  ///< above the outside
  double diameter_mm = 0.0;   ///< at the middle; taken as the mid-surface's
};

/// Checks that a chart can drive a balloon: 2 to 30 points, pressures >= 0 that rise, diameters
/// > 0 that rise.
///
/// @param name  of the balloon, for the message
/// @throws InputError that names the first wrong point
void validate_chart(const std::vector<ChartPoint>& chart, const std::string& name);

/// The diameter [mm] between the chart's points, on straight lines; NaN before the first and past
/// the last: there the chart says nothing.
double chart_diameter_mm(const std::vector<ChartPoint>& chart, double pressure_atm);

/// The unloaded diameter [mm]: the chart's own at 0 atm, or the line through its first two points
/// carried on to 0 atm.
///
/// @throws InputError if that line falls below half the first diameter
double rest_diameter_mm(const std::vector<ChartPoint>& chart);

}  // namespace angio::simulation
