#include "centerline/detail/healthy_line.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace angio::centerline {
namespace {

/// Weighted least squares for a straight line, whose slope is small by itself.
struct LineFit {
  double w = 0.0, wt = 0.0, wtt = 0.0, wy = 0.0, wty = 0.0;

  void add(double weight, double t, double y) {
    w += weight;
    wt += weight * t;
    wtt += weight * t * t;
    wy += weight * y;
    wty += weight * t * y;
  }
  [[nodiscard]] double at_zero() const { return (wy * wtt - wty * wt) / (w * wtt - wt * wt); }
};

/// Tukey's weight of a residual.
double biweight(double residual, double most) {
  const double x = residual / most;
  return std::abs(x) < 1.0 ? (1.0 - x * x) * (1.0 - x * x) : 0.0;
}

/// A cell's diameter above a line (ln), and the length that it stands for.
struct Offset {
  double above, length;
};

/// The standard deviation of normal errors to one side (+1: above), by their median; nothing where
/// less than a fifth of the length lies on that side: of a line through the middle of ten errors
/// that happens once in twenty times, so the line is not in their middle.
std::optional<double> deviation_to(const std::vector<Offset>& offsets, double side) {
  constexpr double kMedian = 0.6745;  // of a standard normal's magnitude
  constexpr double kLeastShare = 0.2;
  std::vector<Offset> there;
  double length = 0.0, whole = 0.0;
  for (const Offset& offset : offsets) {
    whole += offset.length;
    if (side * offset.above < 0.0) continue;
    there.push_back({side * offset.above, offset.length});
    length += offset.length;
  }
  if (there.empty() || length < kLeastShare * whole) return std::nullopt;
  std::sort(there.begin(), there.end(),
            [](const Offset& a, const Offset& b) { return a.above < b.above; });
  double below = 0.0;
  for (const Offset& offset : there) {
    below += offset.length;
    if (below >= 0.5 * length) return offset.above / kMedian;
  }
  return there.back().above / kMedian;
}

}  // namespace

std::vector<double> scatter_around(const std::vector<FieldCell>& cells,
                                   const std::vector<double>& line) {
  constexpr double kReach = 8.0;  // diameters, as for the spreads
  std::vector<double> scatter;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::vector<Offset> healthy;
    for (std::size_t j = 0; j < cells.size(); ++j) {
      const double above = cells[j].log_diameter - line[j];
      if (std::abs(cells[j].abscissa_mm - cells[i].abscissa_mm) <= kReach * std::exp(line[i]) &&
          std::abs(above) <= kHealthy * cells[j].spread)
        healthy.push_back({above, cells[j].length_mm});
    }
    const auto above = deviation_to(healthy, +1.0), below = deviation_to(healthy, -1.0);
    const double spread = cells[i].spread;  // all that is known where nothing is healthy
    scatter.push_back(std::min({spread, above.value_or(spread), below.value_or(spread)}));
  }
  return scatter;
}

std::vector<double> fit_healthy_line(const FieldBranch& branch, const std::vector<double>& best) {
  constexpr double kReach = 6.0;          // diameters: a vessel is about as long between its forks
  constexpr double kTaper = 0.03;         // a diameter: most vessels' is less
  constexpr double kPrior = 0.2;          // how far forks and neighbours miss a vessel's diameter
  constexpr double kLeastScatter = 0.01;  // under what a diameter can be measured to
  const auto& cells = branch.cells;
  std::vector<double> line = best;
  for (const double sharpness : {2.0, 1.0, 0.5, 0.25, 0.0, 0.0}) {
    const std::vector<double> scatter = scatter_around(cells, line);
    std::vector<double> next;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const double diameter = std::exp(line[i]);
      LineFit fit;
      fit.wtt = 1.0 / (kTaper * kTaper);
      fit.add(1.0 / (kPrior * kPrior), 0.0, best[i]);
      for (std::size_t j = 0; j < cells.size(); ++j) {
        const double t = (cells[j].abscissa_mm - cells[i].abscissa_mm) / diameter;
        const double x = std::abs(t) / kReach;
        if (x >= 1.0) continue;
        const double near = std::pow(1.0 - x * x * x, 3.0);
        const double most =
            std::max(sharpness * cells[j].spread, 3.0 * std::max(scatter[j], kLeastScatter));
        const double healthy = biweight(cells[j].log_diameter - line[j], most);
        const double error = std::clamp(scatter[j], kLeastSpread, kMostSpread);
        fit.add(near * healthy * cells[j].length_mm / diameter / (error * error), t,
                cells[j].log_diameter);
      }
      next.push_back(fit.at_zero());
    }
    line = next;
  }
  return line;
}

double value_at(const FieldBranch& branch, const std::vector<double>& line, double position) {
  const auto& cells = branch.cells;
  std::size_t c = 0;
  while (c + 1 < cells.size() && cells[c + 1].position < position) ++c;
  if (c + 1 == cells.size() || position <= cells[c].position) return line[c];
  const double t = (position - cells[c].position) / (cells[c + 1].position - cells[c].position);
  return (1.0 - t) * line[c] + t * line[c + 1];
}

}  // namespace angio::centerline
