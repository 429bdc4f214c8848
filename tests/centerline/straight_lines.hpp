#pragma once

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "core/centerline.hpp"
#include "core/units.hpp"

/// Lines with given radii, without an extraction.
namespace angio::test {

/// A straight line along z, points a quarter of the radius apart, from a diameter at each abscissa.
inline CenterlinePath line_of(const std::function<double(double)>& diameter, double length,
                              int id = 0) {
  CenterlinePath path;
  path.id = id;
  for (double s = 0.0; s <= length; s += 0.125 * diameter(s)) {
    path.points.push_back({0.0, 0.0, s});
    path.inscribed_radius.push_back(0.5 * diameter(s));
  }
  return path;
}

inline CenterlineTree tree_of(std::vector<CenterlinePath> paths) {
  for (CenterlinePath& path : paths) {
    path.abscissa = arc_length(path.points);
    for (const double r : path.inscribed_radius) {
      path.section_area.push_back(units::kPi * r * r);
      path.equivalent_radius.push_back(r);
    }
    if (path.tracts.empty()) path.tracts.push_back({0, int(path.points.size()) - 1, 0, 0, false});
  }
  return {std::move(paths)};
}

/// 1 - depth within `half` of `at`, smoothly.
inline double narrowed(double s, double at, double half, double depth) {
  const double x = (s - at) / half;
  return std::abs(x) < 1.0 ? 1.0 - 0.5 * depth * (1.0 + std::cos(units::kPi * x)) : 1.0;
}

}  // namespace angio::test
