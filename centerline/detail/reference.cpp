#include "centerline/detail/reference.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace angio::centerline {
namespace {

constexpr double kSameVessel = 0.12;   // relative change of diameter across a side branch
constexpr double kTip = 1.0;           // diameters left out at the inlet and at the outlet
constexpr double kLeastHealthy = 2.0;  // diameters of healthy vessel that a fit needs
constexpr double kDiseased = 0.05;     // relative: smaller dips count as healthy
constexpr double kDilated = 0.15;      // relative: wider is ectasia or an aneurysm's neck

struct Samples {
  std::vector<std::size_t> point;    ///< index on the path
  std::vector<double> s, d, weight;  ///< abscissa, diameter, length each stands for [mm]
};

struct TaperLine {
  double at = 0.0, value = 0.0, slope = 0.0;
  [[nodiscard]] double operator()(double s) const { return value + slope * (s - at); }
};

/// Weighted least squares line; a constant when the samples span nothing.
TaperLine fit_line(const Samples& samples, const std::vector<double>& weight) {
  double w = 0.0, ws = 0.0, wd = 0.0;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    w += weight[i];
    ws += weight[i] * samples.s[i];
    wd += weight[i] * samples.d[i];
  }
  TaperLine line{ws / w, wd / w, 0.0};
  double ss = 0.0, sd = 0.0;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    const double s = samples.s[i] - line.at;
    ss += weight[i] * s * s;
    sd += weight[i] * s * (samples.d[i] - line.value);
  }
  if (ss > 0.0) line.slope = sd / ss;
  return line;
}

/// Quantile regression by reweighted least squares: asymmetric absolute values.
TaperLine quantile_line(const Samples& samples, double quantile) {
  std::vector<double> weight = samples.weight;
  TaperLine line = fit_line(samples, weight);
  for (int pass = 0; pass < 30; ++pass) {
    for (std::size_t i = 0; i < weight.size(); ++i) {
      const double e = samples.d[i] - line(samples.s[i]);
      const double side = e > 0.0 ? quantile : 1.0 - quantile;
      weight[i] = samples.weight[i] * side / std::max(std::abs(e), 1e-3 * line.value);
    }
    line = fit_line(samples, weight);
  }
  return line;
}

double weighted_median(std::vector<std::pair<double, double>> value_weight) {
  std::sort(value_weight.begin(), value_weight.end());
  double total = 0.0, sum = 0.0;
  for (const auto& [value, weight] : value_weight) total += weight;
  for (const auto& [value, weight] : value_weight)
    if ((sum += weight) >= 0.5 * total) return value;
  return value_weight.back().first;
}

struct Fit {
  TaperLine line;
  std::vector<char> healthy;
  double healthy_length = 0.0;
};

Fit fit_healthy(const Samples& samples) {
  Fit fit;
  fit.line = quantile_line(samples, 0.7);
  for (int pass = 0; pass < 10; ++pass) {
    // The spread of the samples above the line is not touched by disease.
    std::vector<std::pair<double, double>> above;
    for (std::size_t i = 0; i < samples.s.size(); ++i) {
      const double e = samples.d[i] / fit.line(samples.s[i]) - 1.0;
      if (e >= 0.0) above.emplace_back(e, samples.weight[i]);
    }
    const double spread = above.empty() ? 0.0 : 1.4826 * weighted_median(above);
    const double diseased = std::clamp(2.0 * spread, kDiseased, 0.15);
    std::vector<double> weight(samples.s.size());
    fit.healthy.assign(samples.s.size(), 0);
    fit.healthy_length = 0.0;
    for (std::size_t i = 0; i < samples.s.size(); ++i) {
      const double e = samples.d[i] / fit.line(samples.s[i]) - 1.0;
      if (e < -diseased || (pass > 0 && e > kDilated)) continue;
      fit.healthy[i] = 1;
      fit.healthy_length += samples.weight[i];
      weight[i] = samples.weight[i] * std::min(1.0, diseased / std::max(e, 1e-9));
    }
    if (fit.healthy_length <= 0.0) break;
    const TaperLine next = fit_line(samples, weight);
    const bool settled = std::abs(next(samples.s.front()) - fit.line(samples.s.front())) +
                             std::abs(next(samples.s.back()) - fit.line(samples.s.back())) <
                         1e-6 * fit.line.value;
    fit.line = next;
    if (settled) break;
  }
  return fit;
}

/// The radius of the vessel at an end of a path. The sections right at an oblique cap are cut off
/// by it, so it is the greatest radius within two diameters.
double tip_radius(const CenterlinePath& path, bool at_front) {
  double radius = 0.0;
  const double tip = at_front ? path.abscissa.front() : path.abscissa.back();
  const std::size_t count = path.points.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = at_front ? k : count - 1 - k;
    if (std::abs(path.abscissa[i] - tip) > 4.0 * radius && k > 0) break;
    radius = std::max(radius, path.inscribed_radius[i]);
  }
  return radius;
}

/// The samples of points [first, last], without the tips of the path.
Samples take_samples(const CenterlinePath& path, int first, int last) {
  Samples samples;
  const double begin = path.abscissa.front() + kTip * 2.0 * tip_radius(path, true);
  const double end = path.abscissa.back() - kTip * 2.0 * tip_radius(path, false);
  for (int index = first; index <= last; ++index) {
    const auto i = std::size_t(index);
    if (path.abscissa[i] < begin || path.abscissa[i] > end) continue;
    const std::size_t before = i > 0 ? i - 1 : i;
    const std::size_t after = std::min(i + 1, path.points.size() - 1);
    samples.point.push_back(i);
    samples.s.push_back(path.abscissa[i]);
    samples.d.push_back(2.0 * path.inscribed_radius[i]);
    samples.weight.push_back(0.5 * (path.abscissa[after] - path.abscissa[before]));
  }
  return samples;
}

void append(Samples& to, const Samples& from) {
  to.point.insert(to.point.end(), from.point.begin(), from.point.end());
  to.s.insert(to.s.end(), from.s.begin(), from.s.end());
  to.d.insert(to.d.end(), from.d.begin(), from.d.end());
  to.weight.insert(to.weight.end(), from.weight.begin(), from.weight.end());
}

/// The healthy diameter of a stretch near one of its ends: the upper quartile of the third there.
double level(const Samples& samples, bool at_front) {
  std::vector<double> d;
  const double middle = at_front ? samples.s.front() : samples.s.back();
  const double reach = std::max(0.34 * (samples.s.back() - samples.s.front()), 1e-9);
  for (std::size_t i = 0; i < samples.s.size(); ++i)
    if (std::abs(samples.s[i] - middle) <= reach) d.push_back(samples.d[i]);
  const auto at = d.begin() + std::ptrdiff_t(3 * (d.size() - 1) / 4);
  std::nth_element(d.begin(), at, d.end());
  return *at;
}

bool same_vessel(const Samples& a, const Samples& b) {
  const double before = level(a, false), after = level(b, true);
  return std::abs(before - after) <= kSameVessel * std::max(before, after);
}

/// Joins stretches across side branches that do not change the diameter; a stretch that is
/// narrowed as a whole is joined when its neighbours go together.
std::vector<Samples> find_segments(const CenterlinePath& path) {
  std::vector<Samples> pieces;
  for (const CenterlineTract& tract : path.tracts) {
    if (tract.blanking) continue;
    Samples samples = take_samples(path, tract.first_point, tract.last_point);
    if (samples.s.size() >= 3) pieces.push_back(std::move(samples));
  }
  std::vector<Samples> segments;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    if (segments.empty()) {
      segments.push_back(pieces[k]);
      continue;
    }
    Samples& last = segments.back();
    const bool joins = same_vessel(last, pieces[k]);
    const bool bridges = k + 1 < pieces.size() && level(pieces[k], true) < level(last, false) &&
                         level(pieces[k], false) < level(pieces[k + 1], true) &&
                         same_vessel(last, pieces[k + 1]);
    if (joins || bridges)
      append(last, pieces[k]);
    else
      segments.push_back(pieces[k]);
    if (bridges && !joins) append(segments.back(), pieces[++k]);
  }
  return segments;
}

/// Gives the points of branchings the smaller of the references before and behind.
void bridge_branchings(const CenterlinePath& path, ReferenceDiameter& reference) {
  const std::size_t count = path.points.size();
  for (const CenterlineTract& tract : path.tracts) {
    if (!tract.blanking) continue;
    auto before = std::size_t(tract.first_point), after = std::size_t(tract.last_point);
    while (before > 0 && reference.segment[before] < 0) --before;
    while (after + 1 < count && reference.segment[after] < 0) ++after;
    if (reference.segment[before] < 0 || reference.segment[after] < 0) continue;
    const std::size_t smaller =
        reference.diameter[before] < reference.diameter[after] ? before : after;
    for (std::size_t i = before + 1; i < after; ++i) {
      if (reference.segment[i] >= 0) continue;
      reference.diameter[i] = reference.diameter[smaller];
      reference.interpolated[i] = reference.interpolated[smaller];
      reference.segment[i] = reference.segment[smaller];
    }
  }
}

}  // namespace

ReferenceDiameter find_reference(const CenterlinePath& path) {
  ReferenceDiameter reference;
  const std::size_t count = path.points.size();
  reference.diameter.assign(count, 0.0);
  reference.interpolated.assign(count, 0);
  reference.healthy.assign(count, 0);
  reference.segment.assign(count, -1);
  const std::vector<Samples> segments = find_segments(path);
  std::vector<Fit> fits;
  for (const Samples& samples : segments) fits.push_back(fit_healthy(samples));
  const auto enough = [&](std::size_t k) {
    return fits[k].healthy_length >= kLeastHealthy * fits[k].line.value;
  };
  for (std::size_t k = 0; k < segments.size(); ++k) {
    std::optional<double> average;
    if (!enough(k)) {
      std::optional<double> proximal, distal;
      for (std::size_t before = k; before-- > 0 && !proximal;)
        if (enough(before)) proximal = fits[before].line(segments[before].s.back());
      for (std::size_t after = k + 1; after < segments.size() && !distal; ++after)
        if (enough(after)) distal = fits[after].line(segments[after].s.front());
      if (proximal && distal)
        average = 0.5 * (*proximal + *distal);
      else
        average = level(segments[k], proximal.has_value());
    }
    for (std::size_t i = 0; i < segments[k].s.size(); ++i) {
      const std::size_t p = segments[k].point[i];
      reference.healthy[p] = fits[k].healthy[i];
      reference.diameter[p] = average ? *average : fits[k].line(segments[k].s[i]);
      reference.interpolated[p] = average ? 0 : 1;
      reference.segment[p] = int(k);
    }
  }
  bridge_branchings(path, reference);
  return reference;
}

}  // namespace angio::centerline
