#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "simulation/wall.hpp"

/// Thick tubes under pressure, and what they do exactly.
namespace angio::simulation::testing {

inline WallRegionMaterial neo_hookean(double shear_kpa, double bulk_ratio) {
  return {.shear_kpa = shear_kpa, .bulk_kpa = bulk_ratio * shear_kpa};
}

inline const WallRegionMaterial kFibered{.shear_kpa = 20.0,
                                         .bulk_kpa = 20000.0,
                                         .fiber_k1_kpa = 30.0,
                                         .fiber_k2 = 5.0,
                                         .fiber_angle_deg = 30.0};

inline WallOptions of_one_material(const WallRegionMaterial& m) {
  WallOptions options;
  options.materials.fill(m);
  options.foundation_kpa_per_mm = 1e-3;  // only against rigid motion
  options.axial_stretch = 1.0;
  return options;
}

inline TubeWall round_tube(double inner, double outer, int around, int along, double length) {
  TubeWall tube;
  tube.around = around;
  tube.along = along;
  tube.length_mm = length;
  tube.inner_radius_mm = [=](double, double) { return inner; };
  tube.outer_radius_mm = [=](double, double) { return outer; };
  return tube;
}

/// Mean distance from the z axis of the lumen's or the outer surface's vertices.
inline double mean_radius(const std::vector<Triangle>& surface, const std::vector<Vec3>& x) {
  double sum = 0.0;
  for (const Triangle& t : surface)
    for (const int v : t) {
      const Vec3 p = x[static_cast<std::size_t>(v)];
      sum += std::hypot(p.x, p.y);
    }
  return sum / static_cast<double>(3 * surface.size());
}

/// Psi of an incompressible tube wall in the circumferential and axial stretch [kPa].
inline double energy(const WallRegionMaterial& m, double around, double along) {
  const double across = 1.0 / (around * along);
  const double i1 = around * around + along * along + across * across - 3.0;
  const double c = std::cos(m.fiber_angle_deg * std::numbers::pi / 180.0);
  const double over = c * c * around * around + (1.0 - c * c) * along * along - 1.0;
  const double taut = std::max(over, 0.0);
  double psi = 0.5 * m.shear_kpa * i1;
  if (m.fiber_k1_kpa > 0.0)
    psi += m.fiber_k1_kpa / m.fiber_k2 *
           (std::exp(m.fiber_k2 * ((1.0 - m.fiber_share) * i1 * i1 + m.fiber_share * taut * taut)) -
            1.0);
  return psi;
}

/// The pressure that holds an incompressible tube of unloaded radii A, B at the inner radius a:
/// p = integral of l dPsi/dl dr / r (Holzapfel, Gasser, Ogden 2000, Eq. 35), l = r / R.
inline double tube_pressure(const WallRegionMaterial& m, double unloaded_inner,
                            double unloaded_outer, double inner, double along) {
  const auto radius = [&](double unloaded) {
    return std::sqrt(inner * inner +
                     (unloaded * unloaded - unloaded_inner * unloaded_inner) / along);
  };
  const int steps = 2000;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double big = unloaded_inner + (unloaded_outer - unloaded_inner) * (i + 0.5) / steps;
    const double width = (unloaded_outer - unloaded_inner) / steps;
    const double r = radius(big), l = r / big, h = 1e-6;
    const double slope = (energy(m, l + h, along) - energy(m, l - h, along)) / (2.0 * h);
    sum += l * slope * (big / (along * r)) * width / r;  // dr = R dR / (l_z r)
  }
  return sum;
}

/// Of the displacement, relative; not a number if the solver does not converge.
struct TubeError {
  double inner = 0.0, outer = 0.0;
};

/// A tube of radii 1 and 1.6 mm widened to an inner radius, against tube_pressure.
inline TubeError tube_error(const WallRegionMaterial& m, double inner, int around,
                            std::vector<double> layers) {
  constexpr double kA = 1.0, kB = 1.6;
  TubeWall shape = round_tube(kA, kB, around, 2, 2.0 * std::numbers::pi / around * 1.7);
  shape.layer_regions.assign(layers.size(), WallRegion::media);
  shape.layer_shares = std::move(layers);
  const LayeredWall wall = make_tube_wall(shape);
  const WallOptions options = of_one_material(m);
  const double pressure = tube_pressure(m, kA, kB, inner, 1.0);
  const WallSolution solution = solve_wall(wall, options, unloaded_state(wall), pressure);
  if (!solution.converged) return {std::nan(""), std::nan("")};
  const double outer = std::sqrt(inner * inner + kB * kB - kA * kA);
  return {(mean_radius(wall.lumen_triangles, solution.state.vertices) - inner) / (inner - kA),
          (mean_radius(wall.outer_triangles, solution.state.vertices) - outer) / (outer - kB)};
}

}  // namespace angio::simulation::testing
