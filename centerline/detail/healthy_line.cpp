#include "centerline/detail/healthy_line.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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
  [[nodiscard]] double slope() const { return (w * wty - wt * wy) / (w * wtt - wt * wt); }
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

/// A stretch of a branch whose diameters lie on a line: ln of the diameter at its first cell, and
/// by how much it rises per diameter, and its length in diameters.
struct EvenStretch {
  std::size_t first;
  double value, slope, length;
};

/// The straight line through the cells from one on, over five diameters; nothing where they are
/// not even, or fewer are left.
std::optional<EvenStretch> even_from(const std::vector<FieldCell>& cells, std::size_t first) {
  constexpr double kLength = 5.0, kLongest = 6.5;  // diameters that were measured; in all
  constexpr double kEven = 0.05, kNarrows = -0.08, kWidens = 0.03;
  LineFit fit;
  const auto along = [&](std::size_t c) { return cells[c].position - cells[first].position; };
  std::size_t end = first;
  for (; end < cells.size() && fit.w < kLength; ++end)
    fit.add(cells[end].weight, along(end), cells[end].log_diameter);
  if (fit.w < kLength || along(end - 1) > kLongest) return std::nullopt;
  const EvenStretch even{first, fit.at_zero(), fit.slope(), along(end - 1)};
  double squares = 0.0;
  for (std::size_t c = first; c < end; ++c)
    squares +=
        cells[c].weight * std::pow(cells[c].log_diameter - even.value - even.slope * along(c), 2.0);
  const bool is_even = squares <= kEven * kEven * fit.w;
  return is_even && even.slope >= kNarrows && even.slope <= kWidens ? std::optional(even)
                                                                    : std::nullopt;
}

/// The first even stretch behind a throat, from a cell on.
std::optional<EvenStretch> even_behind_throat(const std::vector<FieldCell>& cells,
                                              std::size_t first) {
  constexpr double kThroat = 0.3;
  double tightest = std::numeric_limits<double>::max();
  for (std::size_t c = first; c < cells.size(); ++c) {
    const std::optional<EvenStretch> even = even_from(cells, c);
    if (even && tightest < even->value + std::log(1.0 - kThroat)) return even;
    tightest = std::min(tightest, cells[c].log_diameter);
  }
  return std::nullopt;
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

std::vector<double> accept_narrower_vessel(const FieldBranch& branch,
                                           const std::vector<double>& line) {
  constexpr double kShoulder = 0.2;
  const auto& cells = branch.cells;
  std::size_t first = cells.size();  // of the cells that are narrow until the branch ends
  while (first > 0 && cells[first - 1].log_diameter < line[first - 1] + std::log(1.0 - kShoulder))
    --first;
  const std::optional<EvenStretch> even = even_behind_throat(cells, first);
  if (!even) return line;
  FieldBranch behind;
  behind.cells.assign(cells.begin() + std::ptrdiff_t(even->first), cells.end());
  const double from = behind.cells.front().position;
  std::vector<double> best;
  for (std::size_t c = 0; c < behind.cells.size(); ++c) {
    // Beyond the stretch that is even the vessel is as wide as at its end.
    const double along = std::min(behind.cells[c].position - from, even->length);
    best.push_back(std::min(even->value + even->slope * along, line[even->first + c]));
  }
  best = fit_healthy_line(behind, best);
  std::vector<double> accepted = line;
  std::copy(best.begin(), best.end(), accepted.begin() + std::ptrdiff_t(even->first));
  const std::size_t last = first > 0 ? first - 1 : first;  // of the wider vessel
  for (std::size_t c = first; c < even->first; ++c) {
    const double t = (cells[c].position - cells[last].position) / (from - cells[last].position);
    accepted[c] = (1.0 - t) * line[last] + t * best.front();
  }
  return accepted;
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
