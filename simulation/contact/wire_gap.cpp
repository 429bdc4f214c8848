#include "simulation/contact/wire_gap.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "simulation/contact/distance.hpp"

namespace angio::simulation::detail {
namespace {

double longest(const Vec3* by, std::size_t count, const Vec3& mean) {
  double most = 0.0;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, norm(by[i] - mean));
  return most;
}

}  // namespace

WireGap wire_gap(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& corners) {
  WireGap least{1e300, 0.0, {}};
  Vec3 gap;
  const auto take = [&](const Vec3& along, double share) {
    const double d = norm(along);
    if (!(d < least.distance)) return;
    least = {d, share, {}};
    gap = along;
  };
  const Vec3* ends[2] = {&a, &b};
  for (int e = 0; e < 2; ++e) {
    const GapWeights<double> w = point_triangle_gap(*ends[e], corners[0], corners[1], corners[2]);
    take(*ends[e] + w.w[1] * corners[0] + w.w[2] * corners[1] + w.w[3] * corners[2], double(e));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &p = corners[k], &q = corners[(k + 1) % 3];
    const GapWeights<double> w = segment_segment_gap(a, b, p, q);
    take(w.w[0] * a + w.w[1] * b + w.w[2] * p + w.w[3] * q, w.w[1]);
  }
  if (least.distance > 0.0) least.direction = gap / least.distance;
  return least;
}

bool runs_through(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& corners) {
  const Vec3 way = b - a, e1 = corners[1] - corners[0], e2 = corners[2] - corners[0];
  const Vec3 h = cross(way, e2);
  const double det = dot(e1, h);
  if (det == 0.0) return false;
  const Vec3 from = a - corners[0], q = cross(from, e1);
  const double u = dot(from, h) / det, v = dot(way, q) / det, t = dot(e2, q) / det;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= 1.0;
}

bool encloses(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x, const Vec3& p) {
  double sum = 0.0;
  for (const Triangle& t : triangles) {
    const Vec3 a = x[std::size_t(t[0])] - p, b = x[std::size_t(t[1])] - p,
               c = x[std::size_t(t[2])] - p;
    sum += 2.0 * std::atan2(dot(a, cross(b, c)), norm(a) * norm(b) * norm(c) + dot(a, b) * norm(c) +
                                                     dot(b, c) * norm(a) + dot(c, a) * norm(b));
  }
  return sum > 2.0 * units::kPi;
}

double free_share(const WireMotion& motion, const Triangle& triangle, const WirePair& pair) {
  constexpr double kLeft = 0.1;    // of the gap: ends the motion
  constexpr double kLeast = 0.05;  // of the gap: what a step leaves in any case
  constexpr int kMostSteps = 200;
  const auto s = std::size_t(pair.segment);
  Vec3 by[5] = {motion.wire_by[s], motion.wire_by[s + 1]};
  std::array<Vec3, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) {
    by[2 + k] = motion.membrane_by[std::size_t(triangle[k])];
    corners[k] = motion.membrane[std::size_t(triangle[k])];
  }
  Vec3 mean;
  for (const Vec3& v : by) mean += 0.2 * v;
  const double closing = longest(by, 2, mean) + longest(by + 2, 3, mean);
  const Vec3 &a = motion.wire[s], &b = motion.wire[s + 1];
  const double start = wire_gap(a, b, corners).distance;
  if (!(start < closing / (1.0 - kLeft))) return 1.0;
  double share = 0.0, step = (1.0 - kLeft) * start / closing;
  for (int i = 0; i < kMostSteps && share + step < 1.0; ++i) {
    const double at = share + step;
    std::array<Vec3, 3> moved;
    for (std::size_t k = 0; k < 3; ++k) moved[k] = corners[k] + at * by[2 + k];
    const double left = wire_gap(a + at * by[0], b + at * by[1], moved).distance;
    share = at;
    if (left < kLeft * start) return share;
    step = (left - kLeast * start) / closing;
  }
  return share + step < 1.0 ? share : 1.0;
}

}  // namespace angio::simulation::detail
