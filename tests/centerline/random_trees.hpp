#pragma once

#include <random>
#include <vector>

#include "testing/centerline/shapes.hpp"

/// Random vessels: bent, tapering trunks with side branches, dilated places and sacs.
namespace angio::test {

struct RandomTree {
  std::vector<Tube> tubes;
  bool has_ectasia = false;
  bool has_sac = false;
};

/// A healthy tree: nothing in it is narrower than its taper says.
inline RandomTree healthy_tree(unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * double(random()) / double(std::mt19937::max());
  };
  RandomTree tree;
  const double length = uniform(25.0, 40.0), radius = uniform(1.3, 2.2);
  const double taper = uniform(0.0, 0.4), bend = uniform(0.0, 0.06), turn = uniform(0.0, 0.05);
  tree.has_ectasia = uniform(0.0, 1.0) < 0.25;
  const double ectasia_at = uniform(0.35, 0.65), ectasia = uniform(0.3, 0.8);
  const auto curve = [=](double t) {
    const double s = t * length;
    return Vec3{0.5 * bend * s * s, turn * s * s * (1.0 - t) * 0.5, s};
  };
  const bool dilated = tree.has_ectasia;
  const auto width = [=](double t) {
    const double x = (t - ectasia_at) / 0.12;
    const double more =
        dilated && std::abs(x) < 1.0 ? 0.5 * ectasia * (1.0 + std::cos(units::kPi * x)) : 0.0;
    return radius * (1.0 - taper * t) * (1.0 + more);
  };
  tree.tubes.push_back(make_tube(curve, width, 300));
  const int branches = int(uniform(0.0, 3.0));
  for (int b = 0; b < branches; ++b) {
    const double t = 0.3 + 0.4 * (b + uniform(0.2, 0.8)) / branches, around = uniform(0.0, 6.283);
    const double share = uniform(0.5, 0.85), angle = uniform(0.6, 1.4);
    const Vec3 ahead = normalized(curve(t + 0.01) - curve(t));
    const Vec3 u = any_perpendicular(ahead), v = cross(ahead, u);
    const Vec3 side = std::cos(around) * u + std::sin(around) * v;
    const Vec3 way = std::cos(angle) * ahead + std::sin(angle) * side;
    const double reach = uniform(10.0, 16.0), r = share * radius * (1.0 - taper * t);
    tree.tubes.push_back(make_tube([=](double x) { return curve(t) + (reach * x) * way; },
                                   [=](double x) { return r * (1.0 - 0.15 * x); }, 150));
  }
  tree.has_sac = uniform(0.0, 1.0) < 0.2;
  if (tree.has_sac) {
    const double t = uniform(0.3, 0.7), size = uniform(1.2, 1.8) * width(t);
    const Vec3 side = any_perpendicular(normalized(curve(t + 0.01) - curve(t)));
    const Vec3 middle = curve(t) + (0.7 * (width(t) + size)) * side;
    tree.tubes.push_back(straight_tube(middle, middle + 0.01 * side, [=](double) { return size; }));
    tree.tubes.back().points.resize(2);
    tree.tubes.back().radius.resize(2);
  }
  return tree;
}

}  // namespace angio::test
