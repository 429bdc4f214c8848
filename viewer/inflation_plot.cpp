#include "viewer/inflation_plot.hpp"

#include <algorithm>
#include <cmath>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "viewer/detail/chart.hpp"
#include "viewer/detail/html.hpp"

namespace angio::viewer {
namespace {

using namespace detail;

// Plain colours: programs that are no browsers know no style variables.
constexpr const char* kStyle = R"css(
.grid{stroke:#e6e8ec}.axis{stroke:#5b6472}.band{fill:#f1f3f6}
.level{stroke:#5b6472;stroke-dasharray:7 5}
text{fill:#1d2128;font:12px system-ui,Arial,sans-serif}.tick{fill:#5b6472}
.title{font-weight:600;font-size:15px}.note{font-weight:600}
.mid{text-anchor:middle}.end{text-anchor:end}
.line{fill:none;stroke-width:2;stroke-linejoin:round}
.dashed{stroke-dasharray:3 4;stroke-width:1.4}
.s1{stroke:#1f6fc4}.s2{stroke:#d9690f}.s3{stroke:#23864a}.s4{stroke:#8a4fb8}
.mark{fill:#fff;stroke-width:2}.hover{fill:transparent;stroke:none}
)css";

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
  const std::string body = svg(chart);
  if (body.empty())
    throw InputError(
        "the inflation has fewer than two points (nothing to plot). Give two "
        "pressures or volumes, or more");
  constexpr int kTitleHeight = 34;
  const std::string width = std::to_string(chart.width);
  const std::string height = std::to_string(chart.height + kTitleHeight);
  write_text_atomically(
      path, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width + "\" height=\"" + height +
                "\" viewBox=\"0 0 " + width + " " + height + "\"><style>" + kStyle +
                "</style><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
                "<text x=\"20\" y=\"24\" class=\"title\">" +
                escape_html(plot.title) + "</text><svg y=\"" + std::to_string(kTitleHeight) +
                "\" width=\"" + width + "\" height=\"" + std::to_string(chart.height) + "\" " +
                body.substr(std::string("<svg ").size()) + "</svg>\n");
}

}  // namespace angio::viewer
