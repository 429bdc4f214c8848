#include "centerline/detail/tube_model.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include "centerline/detail/contour.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr int kDegree = 2;     // of the polynomial along the line
constexpr int kMostOrder = 8;  // of the harmonics
constexpr int kSectors = 24;   // of the coarse look at the wall
constexpr int kContourPoints = 96;
constexpr double kWindows[] = {0.4, 0.6, 0.9, 1.35, 2.0};  // half lengths, in radii
constexpr double kCenterWindow = 0.9;
constexpr double kConfidence = 2.5;  // standard errors
constexpr double kSteepest = 0.82;   // cosine: a wall steeper than 35 degrees is a mouth, no taper

/// A wall point in the frame of the line.
struct Sample {
  double s = 0.0, x = 0.0, y = 0.0;  // along and across the line [mm]
  double radius = 0.0, cos = 1.0, sin = 0.0;
  double weight = 1.0;  // robust
};

/// Stretches the plane so that a flat section becomes a round one of the same area.
struct Stretch {
  double xx = 1.0, xy = 0.0, yy = 1.0;  // symmetric, determinant 1
  [[nodiscard]] Point2 apply(const Point2& p) const {
    return {xx * p.x + xy * p.y, xy * p.x + yy * p.y};
  }
  [[nodiscard]] Point2 undo(const Point2& p) const {
    return {yy * p.x - xy * p.y, xx * p.y - xy * p.x};
  }
};

struct Fit {
  bool valid = false;
  int order = 0;
  double window = 0.0;
  double noise = 0.0;     // robust sd of the residuals
  double score = 0.0;     // penalised, as of AIC
  double count = 0.0;     // independent ones
  Eigen::VectorXd terms;  // m, then cos and sin, then powers of s / window
  Eigen::VectorXd error;  // standard errors of the terms
};

int term_count(int order) { return (2 * order + 1) * (kDegree + 1); }
int first_term(int harmonic, bool sine) {  // harmonic 0 has no sine
  return (harmonic == 0 ? 0 : 2 * harmonic - (sine ? 0 : 1)) * (kDegree + 1);
}

/// Harmonics 1, cos, sin, cos 2, ... of an angle times powers of s, one row of the fit.
template <class Row>
void fill_row(int order, double cosine, double sine, double s, double scale, Row&& row) {
  double c = 1.0, d = 0.0;
  int at = 0;
  const auto put = [&](double value) {
    double power = scale * value;
    for (int k = 0; k <= kDegree; ++k, power *= s) row(at++) = power;
  };
  put(1.0);
  for (int m = 1; m <= order; ++m) {
    const double next = c * cosine - d * sine;
    d = d * cosine + c * sine;
    c = next;
    put(c);
    put(d);
  }
}

double quantile(std::vector<double>& values, double q) {
  const auto at = values.begin() + std::ptrdiff_t(q * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void set_polar(Sample& sample, const Stretch& stretch) {
  const Point2 p = stretch.apply({sample.x, sample.y});
  sample.radius = std::hypot(p.x, p.y);
  sample.cos = sample.radius > 0.0 ? p.x / sample.radius : 1.0;
  sample.sin = sample.radius > 0.0 ? p.y / sample.radius : 0.0;
}

/// The foot of a point on the curve by Newton's method; nothing when there is none nearby.
std::optional<double> find_foot(const LocalCurve& curve, const Vec3& p) {
  double s = dot(p - curve.origin, curve.c1) / norm_squared(curve.c1);
  for (int pass = 0; pass < 4; ++pass) {
    const Vec3 d = p - curve.at(s);
    const Vec3 first = curve.c1 + s * (2.0 * curve.c2 + (3.0 * s) * curve.c3);
    const Vec3 second = 2.0 * curve.c2 + (6.0 * s) * curve.c3;
    const double slope = norm_squared(first) - dot(d, second);
    if (slope <= 0.1 * norm_squared(first)) return std::nullopt;  // beyond the bend's own centre
    s += dot(d, first) / slope;
  }
  return s;
}

std::vector<Sample> gather(const WallPoints& points, const LocalCurve& curve, double radius,
                           double reach, double widest) {
  std::vector<int> found;
  points.collect(curve.origin, std::hypot(reach, widest), found);
  const double margin = std::max(0.1 * radius, 0.5 * points.correlation_length());
  std::vector<Sample> samples;
  samples.reserve(found.size());
  for (const int index : found) {
    const Vec3& p = points.point(index);
    const std::optional<double> s = find_foot(curve, p);
    // Behind the ends of the line is the cap, no wall.
    if (!s || std::abs(*s) >= reach || *s < curve.first + margin || *s > curve.last - margin)
      continue;
    const Vec3 t = curve.tangent(*s);
    const Vec3 u = normalized(curve.u - dot(curve.u, t) * t);
    const Vec3 d = p - curve.at(*s);
    Sample sample;
    sample.s = *s;
    sample.x = dot(d, u);
    sample.y = dot(d, cross(t, u));
    set_polar(sample, {});
    if (sample.radius > widest || sample.radius <= 0.0) continue;
    samples.push_back(sample);
  }
  return samples;
}

int sector_of(const Sample& sample) {
  const double turn = std::atan2(sample.sin, sample.cos) / (2.0 * units::kPi);
  return std::clamp(int((turn - std::floor(turn)) * kSectors), 0, kSectors - 1);
}

/// How far away the wall is all round, sector by sector.
struct Coarse {
  std::array<double, kSectors> radius{};  // lower quartile; 0 where nothing is seen
  double typical = 0.0;
  int gap = kSectors;  // longest run of sectors without wall
};

Coarse look_round(const std::vector<Sample>& samples, double window) {
  std::array<std::vector<double>, kSectors> seen;
  for (const Sample& sample : samples)
    if (std::abs(sample.s) <= window) seen[std::size_t(sector_of(sample))].push_back(sample.radius);
  Coarse coarse;
  std::vector<double> all;
  for (std::size_t k = 0; k < kSectors; ++k)
    if (!seen[k].empty()) all.push_back(coarse.radius[k] = quantile(seen[k], 0.25));
  if (all.empty()) return coarse;
  coarse.typical = quantile(all, 0.35);
  coarse.gap = 0;
  int run = 0;
  for (int k = 0; k < 2 * kSectors; ++k) {
    const double r = coarse.radius[std::size_t(k % kSectors)];
    run = r > 0.0 && r < 2.5 * coarse.typical ? 0 : run + 1;
    coarse.gap = std::max(coarse.gap, std::min(run, kSectors));
  }
  return coarse;
}

/// Leaves out what lies behind the first wall: other vessels, and the far side of a branching.
void keep_first_wall(std::vector<Sample>& samples, const Coarse& coarse) {
  std::erase_if(samples, [&](const Sample& sample) {
    const auto k = std::size_t(sector_of(sample));
    double nearest = coarse.radius[k];
    if (nearest <= 0.0) nearest = coarse.typical;
    return sample.radius > 1.4 * std::min(nearest, 2.5 * coarse.typical);
  });
}

/// Leaves out points that another wall hides from the line.
void keep_visible(std::vector<Sample>& samples, const LocalCurve& curve, const Wall& wall) {
  std::erase_if(samples, [&](const Sample& sample) {
    const Vec3 t = curve.tangent(sample.s);
    const Vec3 u = normalized(curve.u - dot(curve.u, t) * t);
    const Vec3 across = sample.x * u + sample.y * cross(t, u);
    const double least = wall.resolution();  // nearer to the wall than this, nothing can be told
    for (const double part : {0.3, 0.5, 0.7, 0.85, 0.93})
      if ((1.0 - part) * norm(across) > least && !wall.inside(curve.at(sample.s) + part * across))
        return true;
    return false;
  });
}

double kernel(const Sample& sample, double window) {
  const double t = sample.s / window;
  return t * t < 1.0 ? 1.0 - t * t : 0.0;
}

double predict(const Fit& fit, const Sample& sample) {
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, (2 * kMostOrder + 1) * (kDegree + 1), 1> row(
      fit.terms.size());
  fill_row(fit.order, sample.cos, sample.sin, sample.s / fit.window, 1.0,
           [&](int c) -> double& { return row(c); });
  return row.dot(fit.terms);
}

/// Of a positive definite matrix given by its lower half.
Eigen::VectorXd inverse_diagonal(const Eigen::MatrixXd& lower) {
  const Eigen::LLT<Eigen::MatrixXd> factor(lower);
  const Eigen::MatrixXd root =
      factor.matrixL().solve(Eigen::MatrixXd::Identity(lower.rows(), lower.cols()));
  return root.colwise().squaredNorm().transpose();
}

/// Standard errors of the terms and the score of the fit. Errors go together within a patch of the
/// correlation length, so there are fewer independent samples than points.
void set_errors(Fit& fit, const std::vector<double>& residual, const Eigen::VectorXd& weight,
                const Eigen::VectorXd& robust, const Eigen::MatrixXd& normal, double correlation,
                double radius) {
  double rss = 0.0;
  for (Eigen::Index n = 0; n < weight.size(); ++n)
    rss += robust[n] * weight[n] * residual[std::size_t(n)] * residual[std::size_t(n)];
  const double sum = weight.sum();
  fit.count = sum * sum / weight.squaredNorm();
  const double density = fit.count / (2.0 * units::kPi * radius * 1.3 * fit.window);
  const double patch = std::max(1.0, density * 1.4 * correlation * correlation);
  const double samples = fit.count / patch, terms = double(fit.terms.size());
  const double variance = fit.noise * fit.noise * patch;
  fit.error = (variance * inverse_diagonal(normal)).cwiseMax(0.0).cwiseSqrt();
  fit.score = samples * std::log(std::max(rss / sum, 1e-18 * radius * radius)) +
              2.0 * terms * (1.0 + terms / samples);
}

/// Weighted least squares, reweighted by Tukey's biweight. The sample weights go in and out.
Fit fit_window(std::vector<Sample>& samples, double window, int order, int passes,
               double correlation, double radius) {
  Fit fit;
  fit.order = order;
  fit.window = window;
  const int terms = term_count(order);
  std::vector<std::size_t> inside;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (std::abs(samples[i].s) < window) inside.push_back(i);
  const auto count = Eigen::Index(inside.size());
  if (count < std::max(12, terms)) return fit;
  Eigen::MatrixXd rows(terms, count);
  Eigen::VectorXd value(count), weight(count), robust(count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const Sample& sample = samples[inside[std::size_t(n)]];
    fill_row(order, sample.cos, sample.sin, sample.s / window, 1.0,
             [&](int c) -> double& { return rows(c, n); });
    value[n] = sample.radius;
  }
  std::vector<double> residual(inside.size());
  Eigen::MatrixXd normal;
  for (int pass = 0; pass < passes; ++pass) {
    double total = 0.0;
    for (Eigen::Index n = 0; n < count; ++n) {
      const Sample& sample = samples[inside[std::size_t(n)]];
      total += weight[n] = sample.weight * kernel(sample, window);
    }
    const Eigen::MatrixXd weighted = rows * weight.cwiseSqrt().asDiagonal();
    normal.setZero(terms, terms);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(weighted);
    // Rings of vertices far apart do not tell a bend from a level: then there is no bend.
    for (int c = 0; c < terms; ++c)
      normal(c, c) += total * (c % (kDegree + 1) > 0 ? 1e-6 : (c > 0 ? 1e-9 : 0.0));
    fit.terms =
        normal.selfadjointView<Eigen::Lower>().ldlt().solve(rows * weight.cwiseProduct(value));
    const Eigen::VectorXd left = value - rows.transpose() * fit.terms;
    for (Eigen::Index n = 0; n < count; ++n) residual[std::size_t(n)] = std::abs(left[n]);
    std::vector<double> sorted;
    for (std::size_t n = 0; n < residual.size(); ++n)
      if (weight[Eigen::Index(n)] > 0.0) sorted.push_back(residual[n]);
    if (sorted.size() < std::size_t(std::max(12, terms))) return fit;
    fit.noise = 1.4826 * quantile(sorted, 0.5);
    const double cut = 4.685 * std::max(fit.noise, 2e-3 * radius);
    for (std::size_t n = 0; n < residual.size(); ++n) {
      const double t = residual[n] / cut;
      const double keep = t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0;
      samples[inside[n]].weight = robust[Eigen::Index(n)] = keep;
    }
  }
  set_errors(fit, residual, weight, robust, normal, correlation, radius);
  fit.valid = fit.terms.allFinite() && fit.terms[0] > 0.0;
  return fit;
}

/// Shrinks each harmonic, with its course along the line, by what noise is expected to add to it
/// (positive-part James-Stein): a round vessel with a noisy wall stays round, a flat one flat.
void shrink_harmonics(Fit& fit) {
  for (int m = 2; m <= fit.order; ++m) {
    const int c = first_term(m, false), d = first_term(m, true);
    const double power = fit.terms[c] * fit.terms[c] + fit.terms[d] * fit.terms[d];
    const double expected = fit.error[c] * fit.error[c] + fit.error[d] * fit.error[d];
    const double keep = power > 0.0 ? std::max(0.0, 1.0 - expected / power) : 0.0;
    for (int k = 0; k <= kDegree; ++k) {
      fit.terms[c + k] *= keep;
      fit.terms[d + k] *= keep;
    }
  }
}

/// The model's contour in the section's plane.
Contour contour_of(const Fit& fit, const Stretch& stretch) {
  Contour contour;
  for (int i = 0; i < kContourPoints; ++i) {
    Sample at;
    const double theta = 2.0 * units::kPi * i / kContourPoints;
    at.cos = std::cos(theta);
    at.sin = std::sin(theta);
    const double r = std::max(predict(fit, at), 0.0);
    contour.push_back(stretch.undo({r * at.cos, r * at.sin}));
  }
  return contour;
}

/// What makes a flat section round: the inverse root of its second moments.
Stretch find_stretch(const Coarse& coarse) {
  constexpr double kFlat = 1.2;
  Contour contour;
  for (std::size_t k = 0; k < kSectors; ++k) {
    const double theta = 2.0 * units::kPi * (double(k) + 0.5) / kSectors;
    const double seen = coarse.radius[k] > 0.0 ? coarse.radius[k] : coarse.typical;
    const double r = std::min(seen, 2.5 * coarse.typical);
    contour.push_back({r * std::cos(theta), r * std::sin(theta)});
  }
  const ContourMoments m = contour_moments(contour);
  const double det = m.xx * m.yy - m.xy * m.xy;
  if (m.area <= 0.0 || det <= 0.0) return {};
  const double root = std::sqrt(det), trace = m.xx + m.yy;
  const double gap = std::sqrt(std::max(0.25 * trace * trace - det, 0.0));
  const double ratio = (0.5 * trace + gap) / (0.5 * trace - gap);
  if (ratio < kFlat * kFlat) return {};
  // The square root of [xx xy; xy yy] is ([..] + root) / t with t^2 = trace + 2 root; its inverse
  // times root(root), so that the determinant is 1.
  const double t = std::sqrt(trace + 2.0 * root) * std::sqrt(root);
  return {(m.yy + root) / t, -m.xy / t, (m.xx + root) / t};
}

bool agrees(const Fit& a, const Fit& b) {
  // Level, middle and flatness.
  for (const int c :
       {0, first_term(1, false), first_term(1, true), first_term(2, false), first_term(2, true)})
    if (std::abs(a.terms[c] - b.terms[c]) > kConfidence * (a.error[c] + b.error[c])) return false;
  return true;
}

/// The longest window that agrees with all shorter ones.
Fit choose_window(std::vector<Sample>& samples, double radius, double correlation) {
  std::vector<Fit> kept;
  for (const double factor : kWindows) {
    Fit fit = fit_window(samples, factor * radius, 2, 2, correlation, radius);
    if (!fit.valid || fit.count < 2.0 * term_count(2)) continue;
    for (const Fit& shorter : kept)
      if (!agrees(shorter, fit)) return kept.back();
    kept.push_back(std::move(fit));
  }
  if (kept.empty())
    return fit_window(samples, kWindows[std::size(kWindows) - 1] * radius, 2, 2, correlation,
                      radius);
  return kept.back();
}

/// More harmonics as long as they say more than noise.
Fit choose_order(std::vector<Sample>& samples, Fit best, int most_order, double correlation,
                 double radius) {
  for (int order = 4; order <= most_order; order += 2) {
    Fit fit = fit_window(samples, best.window, order, 2, correlation, radius);
    if (!fit.valid || fit.score >= best.score) break;
    best = std::move(fit);
  }
  return best;
}

/// The least value of a smooth function given at even steps: a parabola through the lowest three.
double lowest(const std::vector<double>& values) {
  const auto at = std::min_element(values.begin(), values.end());
  if (at == values.begin() || at + 1 == values.end()) return *at;
  const double before = *(at - 1), after = *(at + 1);
  const double bend = before - 2.0 * *at + after, slope = 0.5 * (after - before);
  return bend > 0.0 ? std::max(*at - 0.5 * slope * slope / bend, 0.5 * *at) : *at;
}

/// The distance from a place in the section to the model's wall, in space: where the vessel tapers,
/// the nearest wall is not in the section.
double sphere_radius(const Fit& fit, const Stretch& stretch, const LocalCurve& curve,
                     const Point2& center) {
  constexpr int kSteps = 4;  // to each side
  const Vec3 q = curve.origin + center.x * curve.u + center.y * curve.v;
  std::vector<double> squared;
  double least = 1e300;
  for (int i = 0; i < kContourPoints; i += 2) {
    Sample at;
    const double theta = 2.0 * units::kPi * i / kContourPoints;
    at.cos = std::cos(theta);
    at.sin = std::sin(theta);
    squared.clear();
    for (int k = -kSteps; k <= kSteps; ++k) {
      at.s = 0.7 * fit.window * k / kSteps;
      if (at.s < curve.first || at.s > curve.last) continue;
      const Vec3 t = curve.tangent(at.s);
      const Vec3 u = normalized(curve.u - dot(curve.u, t) * t);
      const double r = std::max(predict(fit, at), 0.0);
      const Point2 p = stretch.undo({r * at.cos, r * at.sin});
      squared.push_back(norm_squared(curve.at(at.s) + p.x * u + p.y * cross(t, u) - q));
    }
    least = std::min(least, lowest(squared));
  }
  return std::sqrt(least);
}

}  // namespace

LocalCurve fit_curve(const Polyline& line, const std::vector<double>& s, std::size_t i,
                     double reach) {
  LocalCurve curve;
  const std::size_t count = line.points.size();
  std::size_t low = i, high = i;
  while (low > 0 && (s[i] - s[low - 1] < reach || i - low < 2)) --low;
  while (high + 1 < count && (s[high + 1] - s[i] < reach || high - i < 2)) ++high;
  const int degree = std::min<int>(3, int(high - low) - 1);
  Eigen::Matrix4d left = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> right = Eigen::Matrix<double, 4, 3>::Zero();
  const double scale = std::max({reach, s[i] - s[low], s[high] - s[i]});
  for (std::size_t k = low; k <= high; ++k) {
    const double x = (s[k] - s[i]) / scale;
    // Points stand for the length around them.
    const double length = 0.5 * (s[std::min(k + 1, count - 1)] - s[k > 0 ? k - 1 : 0]);
    const double w = length * (1.05 - x * x);
    const Eigen::Vector4d powers(1.0, x, degree > 1 ? x * x : 0.0, degree > 2 ? x * x * x : 0.0);
    left += w * powers * powers.transpose();
    for (int axis = 0; axis < 3; ++axis) right.col(axis) += w * line.points[k][axis] * powers;
  }
  for (int c = 0; c < 4; ++c) left(c, c) += left(0, 0) * 1e-10;
  const Eigen::Matrix<double, 4, 3> solved = left.ldlt().solve(right);
  const auto row = [&](int c) { return Vec3{solved(c, 0), solved(c, 1), solved(c, 2)}; };
  curve.origin = row(0);
  curve.c1 = row(1) / scale;
  curve.c2 = row(2) / (scale * scale);
  curve.c3 = row(3) / (scale * scale * scale);
  curve.first = -s[i];
  curve.last = s.back() - s[i];
  const Vec3 tangent = curve.tangent(0.0);
  curve.u = any_perpendicular(tangent);
  curve.v = cross(tangent, curve.u);
  return curve;
}

double look_for_wall(const WallPoints& points, const LocalCurve& curve, double widest) {
  for (double reach = 0.25 * widest; reach <= widest; reach *= 2.0) {
    const Coarse coarse = look_round(gather(points, curve, reach, reach, widest), reach);
    if (coarse.gap <= kSectors / 2) return coarse.typical;
  }
  return 0.0;
}

TubeSection fit_tube(const WallPoints& points, const LocalCurve& curve, double radius,
                     const Wall* wall, TubeEffort effort) {
  TubeSection section;
  section.center = curve.origin;
  const bool measure = effort == TubeEffort::measure;
  const double reach = (measure ? kWindows[std::size(kWindows) - 1] : kCenterWindow) * radius;
  std::vector<Sample> samples = gather(points, curve, radius, reach, 3.0 * radius);
  if (wall != nullptr && measure) keep_visible(samples, curve, *wall);
  const Coarse coarse = look_round(samples, kCenterWindow * radius);
  if (coarse.gap > kSectors / 2) return section;  // less than half of the wall
  keep_first_wall(samples, coarse);
  // Harmonics finer than the widest gap are not seen.
  const int most_order = std::clamp(kSectors / (2 * std::max(coarse.gap, 1)), 1, kMostOrder);
  const double correlation = points.correlation_length();
  const Stretch stretch = find_stretch(coarse);
  for (Sample& sample : samples) set_polar(sample, stretch);
  Fit fit =
      fit_window(samples, kCenterWindow * radius, std::min(2, most_order), 3, correlation, radius);
  if (!fit.valid) fit = fit_window(samples, reach, std::min(1, most_order), 3, correlation, radius);
  if (!fit.valid) return section;
  if (fit.order >= 2) {
    if (measure) fit = choose_window(samples, radius, correlation);
    if (!fit.valid) return section;
    fit = choose_order(samples, std::move(fit), measure ? most_order : std::min(4, most_order),
                       correlation, radius);
  }
  shrink_harmonics(fit);
  const Contour contour = contour_of(fit, stretch);
  const double most_shift = 0.5 * radius;
  const Circle circle = largest_circle(contour, most_shift);
  if (circle.radius <= 0.0) return section;
  const Point2 middle = section_middle(contour, circle, most_shift);
  const double step = 2.0 * units::kPi / kContourPoints;
  section.center += middle.x * curve.u + middle.y * curve.v;
  section.inscribed_radius = circle.radius;
  if (measure)
    section.inscribed_radius = std::clamp(sphere_radius(fit, stretch, curve, circle.center),
                                          kSteepest * circle.radius, circle.radius);
  section.area = contour_moments(contour).area * step / std::sin(step);
  section.extent = contour_extent(contour, middle);
  section.noise = fit.noise;
  section.window = fit.window;
  section.valid = true;
  return section;
}

}  // namespace angio::centerline
