#pragma once

#include <cmath>
#include <vector>

#include "core/units.hpp"
#include "simulation/simulation.hpp"

/// A balloon whose flaps are wrapped around its shaft, along z, with its poles held.
namespace angio::simulation::testing {

struct FoldedBalloon {
  int folds = 3;
  double core_radius = 0.32;  ///< of the innermost layer [mm]
  double pitch = 0.06;        ///< from layer to layer [mm]
  double wrap = 1.6;          ///< of a flap around the core [radians]
  double length = 4.0;        ///< [mm]
  double end = 1.2;           ///< at either end, in which the folds run out [mm]
  int rings = 15;
  int outer_edges = 10, inner_edges = 5;  ///< of a flap's two layers
};

namespace detail_folded {

struct Ring {
  std::vector<double> angle, radius;  ///< folded
  std::vector<double> rest_angle;     ///< unfolded
  double rest_radius = 0.0;
  double upright = 0.0;  ///< opening at which the inner layers point to the axis
};

/// Layers are spirals that climb by two pitches from flap to flap: an outer one from the root of a
/// flap to the tip of the next, an inner one back.
inline Ring fold(const FoldedBalloon& b) {
  Ring ring;
  const double sector = 2.0 * units::kPi / b.folds, climb = 2.0 * b.pitch / sector;
  for (int f = 0; f < b.folds; ++f) {
    const auto add = [&](double turn, double radius) {
      ring.angle.push_back(f * sector + turn);
      ring.radius.push_back(radius);
    };
    add(0.0, b.core_radius + 0.5 * b.pitch);
    for (int k = 1; k < b.outer_edges; ++k) {
      const double turn = (sector + b.wrap) * k / b.outer_edges;
      add(turn, b.core_radius + climb * turn);
    }
    add(sector + b.wrap, b.core_radius + climb * (sector + b.wrap) - 0.5 * b.pitch);
    for (int k = b.inner_edges - 1; k > 0; --k) {
      const double turn = b.wrap * k / b.inner_edges;
      add(sector + turn, b.core_radius + b.pitch + climb * turn);
    }
  }
  // Unfolded it is a circle of the same length; the outer layers go on turning in it.
  const std::size_t count = ring.angle.size();
  std::vector<double> along{0.0};
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t n = (k + 1) % count;
    const double turn = ring.angle[n] - ring.angle[k], r = ring.radius[k], s = ring.radius[n];
    along.push_back(along.back() + std::sqrt(r * r + s * s - 2.0 * r * s * std::cos(turn)));
  }
  ring.rest_radius = along.back() / (2.0 * units::kPi);
  const double inner_at_rest = sector - along[std::size_t(b.outer_edges)] / ring.rest_radius;
  ring.upright = b.wrap / (b.wrap + inner_at_rest);
  double twist = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    ring.rest_angle.push_back(along[k] / ring.rest_radius);
    twist += (ring.angle[k] - ring.rest_angle[k]) / double(count);
  }
  for (double& angle : ring.angle) angle -= twist;
  return ring;
}

}  // namespace detail_folded

/// Start and rest shape: in the ends the section opens to a circle on the core, and tapers.
inline SimulationModel folded_model(const FoldedBalloon& b) {
  const detail_folded::Ring ring = detail_folded::fold(b);
  const int around = int(ring.angle.size());
  SimulationModel model;
  for (int r = 0; r < b.rings; ++r) {
    const double z = -0.5 * b.length + (r + 1) * b.length / (b.rings + 1);
    const double inside = std::min(1.0, (0.5 * b.length - std::abs(z)) / b.end);
    const double width = std::sqrt(inside * (2.0 - inside));  // an ellipse
    const double rest_radius = std::max(b.core_radius, width * ring.rest_radius);
    // Upright, the flaps lose their height: so the layers keep their order.
    const double opening = 1.0 - inside;
    const double height = std::min(1.0, inside / (1.0 - ring.upright));
    for (int k = 0; k < around; ++k) {
      const auto i = std::size_t(k);
      const double angle = (1.0 - opening) * ring.angle[i] + opening * ring.rest_angle[i];
      const double radius = b.core_radius + height * (ring.radius[i] - b.core_radius);
      model.balloon.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
      model.balloon_rest.push_back({rest_radius * std::cos(ring.rest_angle[i]),
                                    rest_radius * std::sin(ring.rest_angle[i]), z});
    }
  }
  for (int r = 0; r + 1 < b.rings; ++r)
    for (int k = 0; k < around; ++k) {
      const int p = r * around + k, q = r * around + (k + 1) % around;
      model.balloon.triangles.push_back({p, q, q + around});
      model.balloon.triangles.push_back({p, q + around, p + around});
    }
  const int low = b.rings * around, last = low - around;
  for (int k = 0; k < around; ++k) {
    const int n = (k + 1) % around;
    model.balloon.triangles.push_back({low, n, k});
    model.balloon.triangles.push_back({low + 1, last + k, last + n});
  }
  for (const double z : {-0.5 * b.length, 0.5 * b.length}) {
    model.balloon.vertices.push_back({0.0, 0.0, z});
    model.balloon_rest.push_back({0.0, 0.0, z});
  }
  model.balloon_fixed.assign(model.balloon.vertices.size(), 0);
  model.balloon_fixed.end()[-1] = model.balloon_fixed.end()[-2] = 1;
  model.guidewire = {{0.0, 0.0, -0.5 * b.length}, {0.0, 0.0, 0.5 * b.length}};
  model.measure_tangent = {0.0, 0.0, 1.0};
  return model;
}

}  // namespace angio::simulation::testing
