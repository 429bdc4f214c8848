#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "simulation/contact/distance.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation {
namespace {

double distance_to(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x,
                   const Vec3& p) {
  double least = std::numeric_limits<double>::max();
  for (const Triangle& t : triangles) {
    const Vec3 &a = x[std::size_t(t[0])], &b = x[std::size_t(t[1])], &c = x[std::size_t(t[2])];
    const auto gap = detail::point_triangle_gap(p, a, b, c);
    least =
        std::min(least, norm_squared(gap.w[0] * p + gap.w[1] * a + gap.w[2] * b + gap.w[3] * c));
  }
  return std::sqrt(least);
}

}  // namespace

double contact_gap_mm(const SimulationModel& model, const SimulationFrame& frame) {
  const std::vector<double> area = vertex_areas({frame.wall, model.wall.triangles});
  std::vector<double> gap(frame.wall.size(), 0.0);
  parallel_for_uneven(std::ptrdiff_t(gap.size()), [&](std::ptrdiff_t v) {
    if (frame.contact_pressure_kpa[std::size_t(v)] > 0.0)
      gap[std::size_t(v)] =
          distance_to(model.balloon.triangles, frame.balloon, frame.wall[std::size_t(v)]);
  });
  double force = 0.0, sum = 0.0;
  for (std::size_t v = 0; v < gap.size(); ++v) {
    const double here = std::max(frame.contact_pressure_kpa[v], 0.0) * area[v];
    force += here;
    sum += here * gap[v];
  }
  return force > 0.0 ? sum / force : 0.0;
}

}  // namespace angio::simulation
