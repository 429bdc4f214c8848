#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "centerline/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "core/units.hpp"
#include "core/volume.hpp"

/// Tubes with known middle lines, as level sets.
namespace angio::test {

/// What was warned of, without that the inlet is a guess: of shapes whose ends are alike it is.
inline std::vector<std::string> without_inlet(std::vector<std::string> warnings) {
  std::erase_if(warnings, [](const std::string& warning) {
    return warning.starts_with(centerline::kUncertainInlet) ||
           warning.starts_with(centerline::kEitherEnd);
  });
  return warnings;
}

/// A curve with a radius along it.
struct Tube {
  std::vector<Vec3> points;
  std::vector<double> radius;
};

/// Samples curve(t) and radius(t), t in [0, 1], at `count` points.
inline Tube make_tube(const std::function<Vec3(double)>& curve,
                      const std::function<double(double)>& radius, int count = 800) {
  Tube tube;
  for (int i = 0; i < count; ++i) {
    const double t = double(i) / (count - 1);
    tube.points.push_back(curve(t));
    tube.radius.push_back(radius(t));
  }
  return tube;
}

inline Tube straight_tube(const Vec3& a, const Vec3& b,
                          const std::function<double(double)>& radius) {
  return make_tube([=](double t) { return (1.0 - t) * a + t * b; }, radius);
}

/// A half space that is left of the lumen: dot(normal, p) <= offset.
struct Cut {
  Vec3 normal;
  double offset = 0.0;
};

inline VolumeGeometry grid_around(const std::vector<Tube>& tubes, double spacing, double margin,
                                  const Mat3& direction = Mat3::identity()) {
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  for (const Tube& tube : tubes)
    for (std::size_t i = 0; i < tube.points.size(); ++i) {
      const Vec3 p = transpose(direction) * tube.points[i];
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis] - tube.radius[i] - margin);
        high[axis] = std::max(high[axis], p[axis] + tube.radius[i] + margin);
      }
    }
  VolumeGeometry grid;
  grid.spacing = {spacing, spacing, spacing};
  grid.direction = direction;
  grid.origin = direction * low;
  for (int axis = 0; axis < 3; ++axis)
    grid.size[std::size_t(axis)] = int((high[axis] - low[axis]) / spacing) + 2;
  return grid;
}

/// The union of tubes (distance to the segments less the radius, exact for constant radius), less
/// what the cuts take away. Tubes without cuts end in half spheres.
inline Volume<float> level_set_of(const std::vector<Tube>& tubes, const VolumeGeometry& grid,
                                  const std::vector<Cut>& cuts = {}) {
  const double far = 5.0;
  Volume<float> level_set(grid, float(far));
  const double h = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  for (const Tube& tube : tubes)
    for (std::size_t s = 0; s + 1 < tube.points.size(); ++s) {
      const Vec3 a = tube.points[s], along = tube.points[s + 1] - a;
      const double reach = tube.radius[s] + 4.0 * h + norm(along);
      const Vec3 center = grid.index_from_lps(a);
      int low[3], high[3];
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::max(0, int(std::floor(center[axis] - reach / grid.spacing[axis])));
        high[axis] = std::min(grid.size[std::size_t(axis)] - 1,
                              int(std::ceil(center[axis] + reach / grid.spacing[axis])));
      }
      for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
          for (int i = low[0]; i <= high[0]; ++i) {
            const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
            const double t =
                std::clamp(dot(p - a, along) / std::max(norm_squared(along), 1e-300), 0.0, 1.0);
            const double value =
                distance(p, a + t * along) - ((1.0 - t) * tube.radius[s] + t * tube.radius[s + 1]);
            level_set.at(i, j, k) = std::min(level_set.at(i, j, k), float(value));
          }
    }
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        for (const Cut& cut : cuts) {
          const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
          level_set.at(i, j, k) =
              std::max(level_set.at(i, j, k), float(dot(cut.normal, p) - cut.offset));
        }
  return level_set;
}

/// Noise of the wall: white noise over the voxels, smoothed a little as a scanner would.
inline void add_noise(Volume<float>& level_set, double sd_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0.0F, float(sd_mm));
  for (float& value : level_set.values) value += normal(random);
}

inline Mat3 rotation(const Vec3& axis, double angle) {
  const Vec3 u = normalized(axis);
  Mat3 cross_matrix;
  cross_matrix(0, 1) = -u.z;
  cross_matrix(0, 2) = u.y;
  cross_matrix(1, 0) = u.z;
  cross_matrix(1, 2) = -u.x;
  cross_matrix(2, 0) = -u.y;
  cross_matrix(2, 1) = u.x;
  return std::cos(angle) * Mat3::identity() + std::sin(angle) * cross_matrix +
         (1.0 - std::cos(angle)) * outer(u, u);
}

/// Distance from a point to a tube's middle line, and the tube's radius there.
struct Nearest {
  double distance = 0.0, radius = 0.0, t = 0.0;
};
inline Nearest nearest_on(const Tube& tube, const Vec3& p) {
  Nearest best{std::numeric_limits<double>::max(), 0.0, 0.0};
  for (std::size_t s = 0; s + 1 < tube.points.size(); ++s) {
    const Vec3 a = tube.points[s], along = tube.points[s + 1] - a;
    const double t =
        std::clamp(dot(p - a, along) / std::max(norm_squared(along), 1e-300), 0.0, 1.0);
    const double d = distance(p, a + t * along);
    if (d < best.distance)
      best = {d, (1.0 - t) * tube.radius[s] + t * tube.radius[s + 1],
              (double(s) + t) / double(tube.points.size() - 1)};
  }
  return best;
}

/// A closed surface whose vertices stand in rings round a tube's middle line, exactly on its wall;
/// every other ring is turned by half a step.
inline TriangleMesh surface_of(const Tube& tube, int rings, int around) {
  TriangleMesh mesh;
  const int count = int(tube.points.size());
  Vec3 u;
  for (int r = 0; r < rings; ++r) {
    const auto i = std::size_t(std::lround(double(r) / (rings - 1) * (count - 1)));
    const std::size_t before = i > 0 ? i - 1 : i, after = std::min(i + 1, tube.points.size() - 1);
    const Vec3 along = normalized(tube.points[after] - tube.points[before]);
    u = r == 0 ? any_perpendicular(along) : normalized(u - dot(u, along) * along);
    const Vec3 v = cross(along, u);
    for (int k = 0; k < around; ++k) {
      const double theta = 2.0 * units::kPi * (k + 0.5 * (r % 2)) / around;
      mesh.vertices.push_back(tube.points[i] +
                              tube.radius[i] * (std::cos(theta) * u + std::sin(theta) * v));
    }
  }
  const auto at = [&](int r, int k) { return r * around + k % around; };
  for (int r = 0; r + 1 < rings; ++r)
    for (int k = 0; k < around; ++k) {
      const int lean = r % 2;  // towards the nearer vertex of the next ring
      mesh.triangles.push_back({at(r, k), at(r, k + 1), at(r + 1, k + lean)});
      mesh.triangles.push_back({at(r, k + 1 - lean), at(r + 1, k + 1), at(r + 1, k)});
    }
  const int first = int(mesh.vertices.size());
  mesh.vertices.push_back(tube.points.front());
  mesh.vertices.push_back(tube.points.back());
  for (int k = 0; k < around; ++k) {
    mesh.triangles.push_back({at(0, k + 1), at(0, k), first});
    mesh.triangles.push_back({at(rings - 1, k), at(rings - 1, k + 1), first + 1});
  }
  return mesh;
}

}  // namespace angio::test
