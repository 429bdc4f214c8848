#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "simulation/contact/distance.hpp"
#include "simulation/simulation.hpp"

/// How near two surfaces are, by every pair of triangles whose boxes are near: no search of the
/// solver's is used.
namespace angio::simulation::testing {

struct Gaps {
  double least = std::numeric_limits<double>::max();  ///< [mm]
  /// From the triangles around a vertex of the second surface to the first one [mm]; beyond the
  /// reach: the greatest number.
  std::vector<double> around;
};

inline double length_of(const detail::GapWeights<double>& g, const Vec3& a, const Vec3& b,
                        const Vec3& c, const Vec3& d) {
  return norm(g.w[0] * a + g.w[1] * b + g.w[2] * c + g.w[3] * d);
}

/// Between two triangles that do not cross.
inline double triangle_gap(const Vec3 (&p)[3], const Vec3 (&q)[3]) {
  double least = std::numeric_limits<double>::max();
  for (int i = 0; i < 3; ++i) {
    least = std::min(least, length_of(detail::point_triangle_gap(p[i], q[0], q[1], q[2]), p[i],
                                      q[0], q[1], q[2]));
    least = std::min(least, length_of(detail::point_triangle_gap(q[i], p[0], p[1], p[2]), q[i],
                                      p[0], p[1], p[2]));
    for (int j = 0; j < 3; ++j) {
      const Vec3 &a = p[i], &b = p[(i + 1) % 3], &c = q[j], &d = q[(j + 1) % 3];
      least = std::min(least, length_of(detail::segment_segment_gap(a, b, c, d), a, b, c, d));
    }
  }
  return least;
}

inline Gaps measure_gaps(const std::vector<Vec3>& x, const std::vector<Triangle>& xs,
                         const std::vector<Vec3>& y, const std::vector<Triangle>& ys,
                         double reach) {
  struct Item {
    Vec3 p[3], low, high;
    Triangle corners{};
  };
  const auto items_of = [](const std::vector<Vec3>& v, const std::vector<Triangle>& ts) {
    std::vector<Item> items;
    for (const Triangle& t : ts) {
      Item item;
      item.corners = t;
      item.low = item.high = v[std::size_t(t[0])];
      for (std::size_t k = 0; k < 3; ++k) {
        item.p[k] = v[std::size_t(t[k])];
        for (int a = 0; a < 3; ++a) {
          item.low[a] = std::min(item.low[a], item.p[k][a]);
          item.high[a] = std::max(item.high[a], item.p[k][a]);
        }
      }
      items.push_back(item);
    }
    std::sort(items.begin(), items.end(),
              [](const Item& a, const Item& b) { return a.low.z < b.low.z; });
    return items;
  };
  Gaps gaps;
  gaps.around.assign(y.size(), std::numeric_limits<double>::max());
  const std::vector<Item> as = items_of(x, xs);
  for (const Item& b : items_of(y, ys))
    for (const Item& a : as) {
      if (a.low.z > b.high.z + reach) break;
      bool near = true;
      for (int k = 0; k < 3 && near; ++k)
        near = a.low[k] <= b.high[k] + reach && a.high[k] + reach >= b.low[k];
      if (!near) continue;
      const double d = triangle_gap(a.p, b.p);
      gaps.least = std::min(gaps.least, d);
      if (d > reach) continue;
      for (const int v : b.corners)
        gaps.around[std::size_t(v)] = std::min(gaps.around[std::size_t(v)], d);
    }
  return gaps;
}

/// What a frame's contact is worth.
struct ContactCheck {
  double least_gap = std::numeric_limits<double>::max();  ///< [mm]
  int active = 0;                                         ///< wall vertices with contact pressure
  int false_ones = 0;  ///< those with nothing of the balloon nearer than 0.05 mm
};

inline void check_contact(const SimulationModel& model, const SimulationFrame& frame,
                          ContactCheck& check) {
  constexpr double kApart = 0.05;
  const Gaps gaps =
      measure_gaps(frame.balloon, model.balloon.triangles, frame.wall, model.wall.triangles, 0.1);
  check.least_gap = std::min(check.least_gap, gaps.least);
  for (std::size_t v = 0; v < frame.wall.size(); ++v) {
    if (!(frame.contact_pressure_kpa[v] > 0.0)) continue;
    ++check.active;
    check.false_ones += gaps.around[v] >= kApart ? 1 : 0;
  }
}

}  // namespace angio::simulation::testing
