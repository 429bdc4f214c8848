#include "simulation/chart.hpp"

#include <cmath>
#include <cstdio>
#include <limits>

#include "core/error.hpp"
#include "simulation/materials/membrane.hpp"

namespace angio::simulation {

void validate_chart(const std::vector<ChartPoint>& chart, const std::string& name) {
  char text[300];
  // The fibre law needs two nodes more: the unloaded length and the start of its straight part.
  constexpr std::size_t kMost = detail::kMostFibreNodes - 2;
  if (chart.size() < 2 || chart.size() > kMost) {
    std::snprintf(text, sizeof text,
                  "the chart of balloon \"%.80s\" has %zu points (2 to %zu are needed). Give "
                  "pressure-diameter pairs such as [8.0, 3.00]",
                  name.c_str(), chart.size(), kMost);
    throw InputError(text);
  }
  for (std::size_t i = 0; i < chart.size(); ++i) {
    const double p = chart[i].pressure_atm, d = chart[i].diameter_mm;
    const bool in_range = p >= 0.0 && p <= 100.0 && d > 0.0 && d <= 50.0;  // false for NaN
    const bool rises = i == 0 || (p > chart[i - 1].pressure_atm && d > chart[i - 1].diameter_mm);
    if (in_range && rises) continue;
    std::snprintf(text, sizeof text,
                  "the chart of balloon \"%.80s\" is wrong at point %zu, %g atm %g mm (%s). Sort "
                  "the points by pressure and check the units",
                  name.c_str(), i + 1, p, d,
                  in_range ? "pressure and diameter must both rise from point to point"
                           : "a pressure lies in [0, 100] atm, a diameter in (0, 50] mm");
    throw InputError(text);
  }
}

double chart_diameter_mm(const std::vector<ChartPoint>& chart, double pressure_atm) {
  for (std::size_t i = 1; i < chart.size(); ++i) {
    const ChartPoint &a = chart[i - 1], &b = chart[i];
    if (!(pressure_atm >= a.pressure_atm && pressure_atm <= b.pressure_atm)) continue;
    const double t = (pressure_atm - a.pressure_atm) / (b.pressure_atm - a.pressure_atm);
    return (1.0 - t) * a.diameter_mm + t * b.diameter_mm;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double rest_diameter_mm(const std::vector<ChartPoint>& chart) {
  validate_chart(chart, "given");
  const ChartPoint &a = chart[0], &b = chart[1];
  const double rest = a.diameter_mm - a.pressure_atm * (b.diameter_mm - a.diameter_mm) /
                                          (b.pressure_atm - a.pressure_atm);
  if (rest >= 0.5 * a.diameter_mm) return rest;
  char text[300];
  std::snprintf(text, sizeof text,
                "the chart falls too steeply towards 0 atm (the line through its first two points, "
                "%g atm %g mm and %g atm %g mm, meets it at %g mm). Add a point at 0 atm",
                a.pressure_atm, a.diameter_mm, b.pressure_atm, b.diameter_mm, rest);
  throw InputError(text);
}

}  // namespace angio::simulation
