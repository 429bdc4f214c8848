#include "viewer/inflation_plot.hpp"

#include <algorithm>
#include <cmath>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "viewer/detail/chart.hpp"

namespace angio::viewer {
namespace {

using namespace detail;

/// A pressure with a name, marked on the computed curve.
void mark_pressure(const InflationPlot& plot, double pressure, const std::string& name,
                   Chart& chart) {
  const auto& x = plot.pressure_atm;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double low = std::min(x[i - 1], x[i]), high = std::max(x[i - 1], x[i]);
    if (pressure < low || pressure > high || !(high > low)) continue;
    const double share = (pressure - x[i - 1]) / (x[i] - x[i - 1]);
    const double y =
        plot.diameter_mm[i - 1] + share * (plot.diameter_mm[i] - plot.diameter_mm[i - 1]);
    chart.marks.push_back({pressure, y, name, 1});
    return;
  }
}

}  // namespace

void write_inflation_plot(const std::filesystem::path& path, const InflationPlot& plot) {
  Chart chart;
  chart.title = plot.title;
  chart.x_label = "pressure above the outside [atm]";
  chart.y_label = "diameter [mm]";
  chart.y_from_zero = false;
  chart.width = 760;
  chart.height = 420;
  chart.series.push_back({"computed", plot.pressure_atm, plot.diameter_mm, 1, false});
  if (!plot.chart_pressure_atm.empty()) {
    chart.series.push_back({"chart", plot.chart_pressure_atm, plot.chart_diameter_mm, 2, true});
    for (std::size_t i = 0; i < plot.chart_pressure_atm.size(); ++i)
      chart.marks.push_back({plot.chart_pressure_atm[i], plot.chart_diameter_mm[i], "", 2});
  }
  if (plot.nominal_pressure_atm > 0.0)
    mark_pressure(plot, plot.nominal_pressure_atm, "nominal", chart);
  if (plot.rated_burst_pressure_atm > 0.0)
    mark_pressure(plot, plot.rated_burst_pressure_atm, "rated burst", chart);
  const std::string file = svg_file({chart});
  if (file.empty())
    throw InputError(
        "the inflation has fewer than two points (nothing to plot). Give two "
        "pressures or volumes, or more");
  write_text_atomically(path, file);
}

}  // namespace angio::viewer
