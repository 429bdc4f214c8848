#include "centerline/detail/tube_samples.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/units.hpp"

namespace angio::centerline {
namespace {

/// The foot of a point on the curve by Newton's method; nothing when there is none nearby.
std::optional<double> find_foot(const LocalCurve& curve, const Vec3& p) {
  double s = dot(p - curve.origin, curve.c1) / norm_squared(curve.c1);
  for (int pass = 0; pass < 4; ++pass) {
    const Vec3 d = p - curve.at(s);
    const Vec3 first = curve.c1 + s * (2.0 * curve.c2 + (3.0 * s) * curve.c3);
    const Vec3 second = 2.0 * curve.c2 + (6.0 * s) * curve.c3;
    const double slope = norm_squared(first) - dot(d, second);
    if (slope <= 0.1 * norm_squared(first)) return std::nullopt;  // beyond the bend's own centre
    const double step = dot(d, first) / slope;
    s += step;
    if (std::abs(step) < 1e-9) break;
  }
  return s;
}

int sector_of(const Sample& sample) {
  const double turn = sample.angle / (2.0 * units::kPi);
  return std::clamp(int((turn - std::floor(turn)) * kSectors), 0, kSectors - 1);
}

/// Places along the line and radii of the samples of a sector.
using Sector = std::vector<std::pair<double, double>>;

/// The noise of the wall, from differences of samples that follow each other along the line: what
/// the wall's course and other walls add to some of them does not count.
double noise_of_neighbors(std::array<Sector, kSectors>& sectors) {
  std::vector<double> steps;
  for (Sector& sector : sectors) {
    std::sort(sector.begin(), sector.end());
    for (std::size_t n = 1; n < sector.size(); ++n)
      steps.push_back(std::abs(sector[n].second - sector[n - 1].second));
  }
  return steps.empty() ? 0.0 : 1.4826 / std::sqrt(2.0) * quantile(steps, 0.5);
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
  sample.angle = std::atan2(sample.sin, sample.cos);
}

std::vector<Sample> gather(const WallPoints& points, const LocalCurve& curve, double radius,
                           double reach, double widest) {
  std::vector<int> found;
  points.collect(curve.origin, std::hypot(reach, widest), found);
  const double margin = std::max(0.1 * radius, 0.5 * points.correlation_length());
  // More say no more: a section has some thirty unknowns, and points of a level set err together.
  constexpr std::size_t kEnough = 1000;
  const std::size_t step = std::max<std::size_t>(found.size() / kEnough, 1);
  std::vector<Sample> samples;
  samples.reserve(found.size() / step + 1);
  for (std::size_t n = 0; n < found.size(); n += step) {
    const Vec3& p = points.point(found[n]);
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

Coarse look_round(const std::vector<Sample>& samples, double window) {
  std::array<Sector, kSectors> sectors;
  for (const Sample& sample : samples)
    if (std::abs(sample.s) <= window)
      sectors[std::size_t(sector_of(sample))].emplace_back(sample.s, sample.radius);
  Coarse coarse;
  coarse.noise = noise_of_neighbors(sectors);
  std::array<std::vector<double>, kSectors> seen;
  for (std::size_t k = 0; k < kSectors; ++k)
    for (const auto& [at, radius] : sectors[k]) seen[k].push_back(radius);
  std::vector<double> all;
  for (std::size_t k = 0; k < kSectors; ++k)
    if (!seen[k].empty()) all.push_back(coarse.radius[k] = quantile(seen[k], 0.25));
  if (all.empty()) return coarse;
  coarse.typical = quantile(all, 0.35);
  // A slit is long to both sides, the mouth of a branch to one.
  for (std::size_t k = 0; k < kSectors; ++k)
    coarse.longest[k] =
        std::max(2.5 * coarse.typical, 1.5 * coarse.radius[(k + kSectors / 2) % kSectors]);
  coarse.gap = 0;
  int run = 0;
  for (std::size_t k = 0; k < 2 * kSectors; ++k) {
    const double r = coarse.radius[k % kSectors];
    run = r > 0.0 && r < coarse.longest[k % kSectors] ? 0 : run + 1;
    coarse.gap = std::max(coarse.gap, std::min(run, kSectors));
  }
  return coarse;
}

bool is_open_to_both_sides(const Coarse& coarse) {
  for (std::size_t k = 0; k < kSectors; ++k) {
    const double opposite = coarse.radius[(k + kSectors / 2) % kSectors];
    if (coarse.radius[k] <= 0.0 && (opposite <= 0.0 || opposite > 2.0 * coarse.typical))
      return true;
  }
  return false;
}

void keep_first_wall(std::vector<Sample>& samples, const Coarse& coarse) {
  std::erase_if(samples, [&](const Sample& sample) {
    const auto k = std::size_t(sector_of(sample));
    double nearest = coarse.radius[k];
    if (nearest <= 0.0) nearest = coarse.typical;
    nearest = std::min(nearest, coarse.longest[k]);
    // A cut within the noise would leave out the outer half of it, and the radius would be low.
    return sample.radius > nearest + std::max(0.4 * nearest, 4.0 * coarse.noise);
  });
}

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

Stretch find_stretch(const Coarse& coarse) {
  constexpr double kFlat = 1.2;
  Contour contour;
  for (std::size_t k = 0; k < kSectors; ++k) {
    const double theta = 2.0 * units::kPi * (double(k) + 0.5) / kSectors;
    const double seen = coarse.radius[k] > 0.0 ? coarse.radius[k] : coarse.typical;
    const double r = std::min(seen, coarse.longest[k]);
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

}  // namespace angio::centerline
