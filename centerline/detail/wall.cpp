#include "centerline/detail/wall.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace angio::centerline {

LevelSetWall::LevelSetWall(const Volume<float>& level_set)
    : level_set_(level_set),
      step_(std::min({level_set.geometry.spacing.x, level_set.geometry.spacing.y,
                      level_set.geometry.spacing.z})) {}

bool LevelSetWall::inside(const Vec3& point) const {
  return linear(level_set_.geometry.index_from_lps(point)) < 0.0;
}

double LevelSetWall::depth_in_data(const Vec3& point) const {
  const VolumeGeometry& grid = level_set_.geometry;
  const Vec3 index = grid.index_from_lps(point);
  double depth = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double last = grid.size[std::size_t(axis)] - 1;
    depth = std::min(depth, grid.spacing[axis] * std::min(index[axis], last - index[axis]));
  }
  return depth;
}

double LevelSetWall::linear(const Vec3& index) const {
  const auto& n = level_set_.geometry.size;
  int low[3], high[3];
  double t[3];
  for (int axis = 0; axis < 3; ++axis) {
    const int last = n[std::size_t(axis)] - 1;
    const double u = std::clamp(index[axis], 0.0, double(last));
    low[axis] = int(u);
    high[axis] = std::min(low[axis] + 1, last);
    t[axis] = u - low[axis];
  }
  const auto value = [&](int i, int j, int k) { return double(level_set_.at(i, j, k)); };
  const auto row = [&](int j, int k) {
    return (1.0 - t[0]) * value(low[0], j, k) + t[0] * value(high[0], j, k);
  };
  const auto slab = [&](int k) { return (1.0 - t[1]) * row(low[1], k) + t[1] * row(high[1], k); };
  return (1.0 - t[2]) * slab(low[2]) + t[2] * slab(high[2]);
}

double LevelSetWall::cubic(const Vec3& index) const {
  const auto& n = level_set_.geometry.size;
  int at[3][4];
  double w[3][4];
  for (int axis = 0; axis < 3; ++axis) {
    const int last = n[std::size_t(axis)] - 1;
    const double u = std::clamp(index[axis], 0.0, double(last));
    const int base = std::min(int(u), std::max(last - 1, 0));
    const double t = u - base;
    const double t2 = t * t, t3 = t2 * t;
    w[axis][0] = 0.5 * (-t3 + 2.0 * t2 - t);
    w[axis][1] = 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0);
    w[axis][2] = 0.5 * (-3.0 * t3 + 4.0 * t2 + t);
    w[axis][3] = 0.5 * (t3 - t2);
    for (int m = 0; m < 4; ++m) at[axis][m] = std::clamp(base + m - 1, 0, last);
  }
  double sum = 0.0;
  for (int c = 0; c < 4; ++c)
    for (int b = 0; b < 4; ++b) {
      double row = 0.0;
      for (int a = 0; a < 4; ++a)
        row += w[0][a] * double(level_set_.at(at[0][a], at[1][b], at[2][c]));
      sum += w[2][c] * w[1][b] * row;
    }
  return sum;
}

double LevelSetWall::ray(const Vec3& from, const Vec3& direction, double longest) const {
  const Vec3 start = level_set_.geometry.index_from_lps(from);
  const Vec3 along = level_set_.geometry.index_from_lps(from + direction) - start;
  const auto at = [&](double s) { return start + s * along; };
  double inside = 0.0, value_inside = linear(start);
  if (value_inside >= 0.0) return 0.0;
  double outside = 0.0, value_outside = value_inside;
  while (value_outside < 0.0) {
    inside = outside;
    value_inside = value_outside;
    if (inside >= longest) return longest;
    outside = std::min(inside + 0.5 * step_, longest);
    value_outside = linear(at(outside));
  }
  const double linear_root =
      inside + (outside - inside) * value_inside / (value_inside - value_outside);
  // One regula falsi step on the tricubic interpolant around the trilinear root.
  const double a = std::max(linear_root - 0.3 * step_, 0.0), b = linear_root + 0.3 * step_;
  const double fa = cubic(at(a)), fb = cubic(at(b));
  if (!(fa < 0.0 && fb > 0.0)) return linear_root;
  const double secant = a + (b - a) * fa / (fa - fb);
  const double fs = cubic(at(secant));
  const double slope = (fb - fa) / (b - a);
  return std::min(std::clamp(secant - fs / slope, a, b), longest);
}

}  // namespace angio::centerline
