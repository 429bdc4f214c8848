#include "simulation/pressed_wall.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"

namespace angio::simulation {
namespace {

/// Over the balloon's diameter: at 16 edges around, what parts two vertices.
constexpr double kReachOfDiameter = 0.2;
constexpr double kPressedShare = 0.05;

using Weighted = std::vector<std::pair<double, double>>;  // pressure and area

/// The mean of the vertex pressures around each vertex.
std::vector<double> means_around(const TriangleMesh& wall, const std::vector<double>& areas,
                                 const std::vector<double>& pressure, double reach) {
  const std::vector<std::vector<int>> neighbors = vertex_neighbors(wall);
  std::vector<double> mean(pressure.size(), 0.0);
  constexpr std::ptrdiff_t kChunk = 256;  // vertices that share their marks
  const auto count = std::ptrdiff_t(pressure.size());
  parallel_for_uneven((count + kChunk - 1) / kChunk, [&](std::ptrdiff_t chunk) {
    std::vector<int> last_seen_by(pressure.size(), -1), disc;
    for (std::ptrdiff_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      const Vec3& center = wall.vertices[std::size_t(i)];
      disc.assign(1, int(i));
      last_seen_by[std::size_t(i)] = int(i);
      double force = 0.0, area = 0.0;
      for (std::size_t next = 0; next < disc.size(); ++next) {
        const auto j = std::size_t(disc[next]);
        const double away = norm(wall.vertices[j] - center);
        const double weight = j == std::size_t(i) ? 1.0 : std::max(0.0, 1.0 - away / reach);
        if (!(weight > 0.0)) continue;
        force += weight * areas[j] * pressure[j];
        area += weight * areas[j];
        for (const int k : neighbors[j]) {
          if (last_seen_by[std::size_t(k)] == int(i)) continue;
          last_seen_by[std::size_t(k)] = int(i);
          disc.push_back(k);
        }
      }
      if (area > 0.0) mean[std::size_t(i)] = force / area;
    }
  });
  return mean;
}

}  // namespace

PressedWall pressed_wall(const std::vector<Triangle>& triangles, const SimulationFrame& frame) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const TriangleMesh wall{frame.wall, triangles};
  const std::vector<double> areas = vertex_areas(wall);
  const std::vector<double>& pressure = frame.contact_pressure_kpa;
  const double reach =
      frame.balloon_diameter_mm > 0.0 ? kReachOfDiameter * frame.balloon_diameter_mm : 0.0;
  const double least =
      kPressedShare *
      std::max(0.0, units::kilopascal_from_pascal(units::pascal_from_atm(frame.pressure_atm)));
  PressedWall pressed;
  pressed.pressure_kpa = means_around(wall, areas, pressure, reach);
  Weighted weighted;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    constexpr double kNewtonPerKpaMm2 = 1e-3;
    pressed.force_n += kNewtonPerKpaMm2 * pressure[v] * areas[v];
    const bool is_pressed = pressed.pressure_kpa[v] > least;
    pressed.is_pressed.push_back(is_pressed ? 1 : 0);
    if (!is_pressed || !(areas[v] > 0.0)) continue;
    pressed.area_mm2 += areas[v];
    weighted.emplace_back(pressed.pressure_kpa[v], areas[v]);
  }
  pressed.median_kpa = weighted.empty() ? kNone : weighted_quantile(weighted, 0.5);
  pressed.p99_kpa = weighted.empty() ? kNone : weighted_quantile(weighted, 0.99);
  return pressed;
}

std::optional<ContactPressure> contact_pressure(const std::vector<Triangle>& triangles,
                                                const SimulationFrame& frame) {
  const std::vector<double> areas = vertex_areas({frame.wall, triangles});
  Weighted touched;
  for (std::size_t v = 0; v < areas.size(); ++v)
    if (frame.contact_pressure_kpa[v] > 0.0 && areas[v] > 0.0)
      touched.emplace_back(frame.contact_pressure_kpa[v], areas[v]);
  if (touched.empty()) return std::nullopt;
  return ContactPressure{weighted_quantile(touched, 0.5), weighted_quantile(touched, 0.99)};
}

}  // namespace angio::simulation
