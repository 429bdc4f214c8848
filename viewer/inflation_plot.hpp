#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace angio::viewer {

/// A balloon's diameter against its pressure, and what its chart says.
struct InflationPlot {
  std::string title;
  std::vector<double> pressure_atm, diameter_mm;              ///< computed, shape [point]
  std::vector<double> chart_pressure_atm, chart_diameter_mm;  ///< the chart's; may be empty
  double nominal_pressure_atm = 0.0;                          ///< 0: not marked
  double rated_burst_pressure_atm = 0.0;                      ///< 0: not marked
};

/// Writes an SVG file of its own (colours inside, white background), atomically.
/// @throws InputError if fewer than two points are finite
void write_inflation_plot(const std::filesystem::path& path, const InflationPlot& plot);

}  // namespace angio::viewer
