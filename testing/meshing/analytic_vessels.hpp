#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/centerline.hpp"
#include "core/volume.hpp"

/// Vessels whose level sets, lines and volumes are known in closed form.
namespace angio::meshing::test {

struct Vessel {
  Volume<float> level_set;
  CenterlineTree tree;
  std::function<double(const Vec3&)> signed_distance;
};

inline Volume<float> sample_level_set(const Vec3& low, const Vec3& high, double spacing,
                                      const std::function<double(const Vec3&)>& function) {
  VolumeGeometry grid;
  for (std::size_t axis = 0; axis < 3; ++axis)
    grid.size[axis] = int(std::ceil((high[int(axis)] - low[int(axis)]) / spacing)) + 1;
  grid.spacing = {spacing, spacing, spacing};
  grid.origin = low;
  Volume<float> volume(grid);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        volume.at(i, j, k) =
            float(function(grid.lps_from_index({double(i), double(j), double(k)})));
  return volume;
}

inline CenterlinePath make_path(int id, std::vector<Vec3> points,
                                const std::vector<double>& radii) {
  CenterlinePath path;
  path.id = id;
  path.abscissa = arc_length(points);
  path.inscribed_radius = radii;
  path.equivalent_radius = radii;
  for (const double r : radii) path.section_area.push_back(std::numbers::pi * r * r);
  path.tracts = {{0, int(points.size()) - 1, 0, 0, false}};
  path.points = std::move(points);
  return path;
}

/// A tube along z from 0 to `length`, of radius r(z), closed by flat ends at the line's ends.
inline Vessel make_tube(double length, double spacing, const std::function<double(double)>& radius,
                        double step = 0.25) {
  Vessel vessel;
  double widest = 0.0;
  std::vector<Vec3> points;
  std::vector<double> radii;
  const int count = int(std::lround(length / step));
  for (int i = 0; i <= count; ++i) {
    const double z = length * i / count;
    points.push_back({0.0, 0.0, z});
    radii.push_back(radius(z));
    widest = std::max(widest, radii.back());
  }
  vessel.signed_distance = [radius, length](const Vec3& p) {
    const double wall = std::hypot(p.x, p.y) - radius(std::clamp(p.z, 0.0, length));
    return std::max({wall, -p.z, p.z - length});
  };
  const double margin = widest + 3.0 * spacing;
  // Off the lattice, so that nothing lies on voxels by chance.
  vessel.level_set =
      sample_level_set({-margin + 0.013, -margin - 0.007, -3.0 * spacing + 0.011},
                       {margin, margin, length + 3.0 * spacing}, spacing, vessel.signed_distance);
  vessel.tree.paths = {make_path(0, points, radii)};
  return vessel;
}

/// Two such tubes of one radius, side by side and apart: two trees.
inline Vessel make_two_tubes(double length, double radius, double spacing) {
  const Vessel one = make_tube(length, spacing, [=](double) { return radius; });
  const Vec3 beside{4.0 * radius, 0.0, 0.0};
  Vessel vessel;
  vessel.signed_distance = [=](const Vec3& p) {
    return std::min(one.signed_distance(p), one.signed_distance(p - beside));
  };
  const double margin = radius + 3.0 * spacing;
  vessel.level_set = sample_level_set({-margin + 0.013, -margin - 0.007, -3.0 * spacing + 0.011},
                                      Vec3{margin, margin, length + 3.0 * spacing} + beside,
                                      spacing, vessel.signed_distance);
  CenterlinePath second = one.tree.paths.front();
  second.id = 1;
  second.tracts.front().group_id = 1;
  for (Vec3& p : second.points) p += beside;
  vessel.tree.paths = {one.tree.paths.front(), second};
  return vessel;
}

/// A narrowing in the middle of a straight tube: r(z) = R (1 - s (1 + cos(pi u)) / 2), |u| < 1.
inline std::function<double(double)> stenosis(double radius, double middle, double half_length,
                                              double severity) {
  return [=](double z) {
    const double u = std::clamp((z - middle) / half_length, -1.0, 1.0);
    return radius * (1.0 - severity * 0.5 * (1.0 + std::cos(std::numbers::pi * u)));
  };
}

/// An arc of a torus: axis radius `bend` in the plane y = 0, from angle 0 to `angle`.
inline Vessel make_arc(double radius, double bend, double angle, double spacing) {
  Vessel vessel;
  std::vector<Vec3> points;
  const int count = int(std::ceil(angle * bend / 0.25));
  for (int i = 0; i <= count; ++i) {
    const double a = angle * i / count;
    points.push_back({bend * std::cos(a), 0.0, bend * std::sin(a)});
  }
  vessel.signed_distance = [=](const Vec3& p) {
    double a = std::atan2(p.z, p.x);
    if (a < 0.5 * angle - std::numbers::pi) a += 2.0 * std::numbers::pi;
    a = std::clamp(a, 0.0, angle);
    const Vec3 axis{bend * std::cos(a), 0.0, bend * std::sin(a)};
    return distance(p, axis) - radius;
  };
  const double m = radius + 3.0 * spacing;
  const double low = angle > std::numbers::pi ? -bend - m : -m;
  vessel.level_set = sample_level_set({-bend - m + 0.013, -m - 0.007, low + 0.011},
                                      {bend + m, m, bend + m}, spacing, vessel.signed_distance);
  vessel.tree.paths = {make_path(0, points, std::vector<double>(points.size(), radius))};
  return vessel;
}

inline double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double t = std::clamp(dot(p - a, along) / norm_squared(along), 0.0, 1.0);
  return distance(p, a + t * along);
}

/// A trunk along z that ends in branches at `half_angle` to it, evenly around it; two lie in the
/// plane y = 0.
inline Vessel make_branching(int branch_count, double trunk_radius, double branch_radius,
                             double trunk_length, double branch_length, double half_angle,
                             double spacing) {
  Vessel vessel;
  const Vec3 start{0.0, 0.0, 0.0};
  const Vec3 fork{0.0, 0.0, trunk_length};
  std::vector<Vec3> tips;
  for (int b = 0; b < branch_count; ++b) {
    const double turn = std::numbers::pi * (1.0 + 2.0 * b / branch_count);
    const Vec3 direction{std::cos(turn) * std::sin(half_angle),
                         std::sin(turn) * std::sin(half_angle), std::cos(half_angle)};
    tips.push_back(fork + branch_length * direction);
  }
  vessel.signed_distance = [=](const Vec3& p) {
    double least = distance_to_segment(p, start, fork) - trunk_radius;
    for (const Vec3& tip : tips)
      least = std::min(least, distance_to_segment(p, fork, tip) - branch_radius);
    return least;
  };
  for (int b = 0; b < branch_count; ++b) {
    std::vector<Vec3> points;
    std::vector<double> radii;
    const int trunk_count = int(std::ceil(trunk_length / 0.25));
    for (int i = 0; i < trunk_count; ++i) {
      points.push_back(start + (double(i) / trunk_count) * (fork - start));
      radii.push_back(trunk_radius);
    }
    const int point_count = int(std::ceil(branch_length / 0.25));
    for (int i = 0; i <= point_count; ++i) {
      const double t = double(i) / point_count;
      points.push_back(fork + t * (tips[std::size_t(b)] - fork));
      const double from_fork = t * branch_length;
      radii.push_back(std::max(branch_radius, trunk_radius - from_fork));
    }
    CenterlinePath path = make_path(b, points, radii);
    path.tracts = {{0, trunk_count, 0, 0, false},
                   {trunk_count, int(points.size()) - 1, 1 + b, 1, false}};
    vessel.tree.paths.push_back(std::move(path));
  }
  const double m = trunk_radius + 3.0 * spacing;
  const double wide = branch_length * std::sin(half_angle) + m;
  const double deep = branch_count > 2 ? wide : m;
  vessel.level_set =
      sample_level_set({-wide + 0.013, -deep - 0.007, -m + 0.011},
                       {wide, deep, trunk_length + branch_length * std::cos(half_angle) + m},
                       spacing, vessel.signed_distance);
  return vessel;
}

inline Vessel make_fork(double trunk_radius, double branch_radius, double trunk_length,
                        double branch_length, double half_angle, double spacing) {
  return make_branching(2, trunk_radius, branch_radius, trunk_length, branch_length, half_angle,
                        spacing);
}

}  // namespace angio::meshing::test
