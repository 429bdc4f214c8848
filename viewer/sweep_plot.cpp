#include "viewer/sweep_plot.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/atomic_file.hpp"
#include "formats/text.hpp"
#include "viewer/detail/chart.hpp"

namespace angio::viewer {

namespace {

/// A twentieth of the value, and two points of a percentage: what is less is no trend.
double least_span(const SweepPanel& panel) {
  constexpr double kShare = 0.05, kPoints = 2.0;
  double highest = 0.0;
  for (const SweepCurve& curve : panel.curves)
    for (const double y : curve.y)
      if (std::isfinite(y)) highest = std::max(highest, std::abs(y));
  const bool is_percentage = panel.measure.find("[%") != std::string::npos;
  return std::max(kShare * highest, is_percentage ? kPoints : 0.0);
}

}  // namespace

bool write_sweep_plot(const std::filesystem::path& path, const std::string& setting,
                      const std::vector<SweepPanel>& panels,
                      const std::vector<std::string>& notes) {
  constexpr int kColors = 4;
  std::vector<detail::Chart> charts;
  for (const SweepPanel& panel : panels) {
    detail::Chart& chart = charts.emplace_back();
    chart.title = panel.measure;
    chart.x_label = setting;
    chart.y_label = panel.measure;
    chart.y_from_zero = false;
    chart.y_least_span = least_span(panel);
    if (panel.limit)
      chart.levels.push_back({*panel.limit, "limit " + formats::number_text(*panel.limit)});
    std::set<double> tried;
    int color = 0;
    for (const SweepCurve& curve : panel.curves) {
      color = color % kColors + 1;
      const bool has_name = !curve.label.empty();
      chart.series.push_back({curve.label, curve.x, curve.y, color, false, has_name});
      for (std::size_t i = 0; i < curve.x.size(); ++i)
        if (std::isfinite(curve.y[i])) {
          chart.marks.push_back({curve.x[i], curve.y[i], "", color});
          tried.insert(curve.x[i]);
        }
    }
    chart.x_ticks.assign(tried.begin(), tried.end());
  }
  const std::string file = detail::svg_file(charts, notes);
  if (file.empty()) return false;
  write_text_atomically(path, file);
  return true;
}

}  // namespace angio::viewer
