#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "benchmarks/contact_rows.hpp"
#include "core/units.hpp"
#include "simulation/contact/contact_force.hpp"
#include "simulation/contact/distance.hpp"
#include "simulation/materials/material.hpp"
#include "simulation/newton/membrane_term.hpp"
#include "testing/simulation/gaps.hpp"
#include "testing/simulation/models.hpp"

namespace angio::simulation {
namespace {

/// Two planes |x| = a as the walls of a flat channel: a point's distance to them is exact, no pair
/// of primitives is searched, no area is shared out.
class ChannelTerm final : public detail::EnergyTerm {
 public:
  ChannelTerm(double half, double reach, double stiffness, std::vector<double> area)
      : half_(half), reach_(reach), stiffness_(stiffness), area_(std::move(area)) {}

  [[nodiscard]] double value(const std::vector<Vec3>& x) const override {
    double sum = 0.0;
    each(x, [&](std::size_t v, double, double gap) {
      sum += gap > 0.0 ? stiffness_ * area_[v] * detail::barrier(gap, reach_).value
                       : std::numeric_limits<double>::infinity();
    });
    return sum;
  }
  void add(const std::vector<Vec3>& x, bool, detail::Assembly& out) const override {
    std::vector<Mat3> blocks(x.size());
    each(x, [&](std::size_t v, double side, double gap) {
      const auto b = detail::barrier(gap, reach_);
      Vec3 slope;
      slope.x = -side * stiffness_ * area_[v] * b.slope;
      out.add_gradient(int(v), slope);
      blocks[v](0, 0) += stiffness_ * area_[v] * b.curvature;
    });
    for (std::size_t v = 0; v < x.size(); ++v) out.add_block(int(v), int(v), blocks[v]);
  }
  /// Sum of the forces on both planes [uN].
  [[nodiscard]] double force(const std::vector<Vec3>& x) const {
    double sum = 0.0;
    each(x, [&](std::size_t v, double, double gap) {
      sum -= stiffness_ * area_[v] * detail::barrier(gap, reach_).slope;
    });
    return sum;
  }

 private:
  template <class Body>
  void each(const std::vector<Vec3>& x, const Body& body) const {
    for (std::size_t v = 0; v < x.size(); ++v)
      for (const double side : {-1.0, 1.0}) body(v, side, half_ - side * x[v].x);
  }
  double half_, reach_, stiffness_;
  std::vector<double> area_;
};

constexpr double kHalf = 0.44, kFarHalf = 0.9;  // of the channel [mm]

SimulationModel flat_channel() {
  testing::StenosedTube p;
  p.start_radius = 0.4;
  p.stenosis = 0.0;
  p.length = 14.0;
  p.lesion_length = 4.0;
  p.balloon_length = 6.0;
  p.balloon_rings = 19;
  p.balloon_around = 20;
  SimulationModel model = testing::make_model(p);
  model.balloon_rest = model.balloon.vertices;
  for (std::size_t v = 0; v < model.balloon_fixed.size(); ++v)  // the end rings too: no free spin
    if (std::abs(model.balloon.vertices[v].z) > 0.44 * p.balloon_length) model.balloon_fixed[v] = 1;
  model.wall = testing::open_tube(p.length, 57, 32, [&](double, double angle) {
    return std::min(kHalf / std::max(1e-9, std::abs(std::cos(angle))),
                    kFarHalf / std::max(1e-9, std::abs(std::sin(angle))));
  });
  model.wall_fixed.assign(model.wall.vertices.size(), 1);
  model.wall_abscissa.clear();
  for (const Vec3& v : model.wall.vertices) model.wall_abscissa.push_back(v.z + 0.5 * p.length);
  model.wall_group.assign(model.wall.vertices.size(), 0);
  return model;
}

SimulationOptions pressed_in_channel() {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.inflation.control = InflationControl::pressure;
  options.inflation.peak_pressure_atm = 2.5;
  options.inflation.inflate_s = 0.5;
  options.inflation.hold_s = 0.5;
  options.inflation.deflate_s = options.frame_s;
  options.inflation.rest_s = 0.0;
  options.tolerance = 1e-4;
  options.contact.distance_mm = 0.01;  // as 0.03 to an artery
  options.contact.friction_static = options.contact.friction_kinetic =
      options.contact.adhesion_traction_kpa = 0.0;
  return options;
}

/// A balloon at rest between the planes.
struct Pressed {
  std::vector<Vec3> balloon;
  double volume = 0.0, force = 0.0;  ///< [mm^3], on both planes [uN]
  bool converged = true;
};

Pressed by_the_step(const SimulationModel& model, const SimulationOptions& options) {
  Pressed result;
  simulate(model, options, [&](const SimulationFrame& f) {
    if (f.phase != Phase::hold) return;
    TriangleMesh wall = model.wall;
    wall.vertices = f.wall;
    const auto areas = vertex_areas(wall);
    result = {f.balloon, f.balloon_volume_mm3};
    for (std::size_t v = 0; v < areas.size(); ++v)
      result.force += units::pascal_from_kilopascal(f.contact_pressure_kpa[v]) * areas[v];
  });
  return result;
}

/// @param areas  that the balloon's vertices stand for [mm^2]
Pressed by_newton(const SimulationModel& model, const SimulationOptions& options,
                  const std::vector<double>& areas) {
  const double pressure = units::pascal_from_atm(options.inflation.peak_pressure_atm);
  const detail::MembraneTerm skin(detail::membrane_law(options.balloon), model.balloon.triangles,
                                  model.balloon_rest, options.balloon.wall_mm);
  const ChannelTerm channel(kHalf, options.contact.distance_mm,
                            detail::barrier_stiffness(pressure, options.contact.distance_mm),
                            areas);
  std::vector<char> fixed;
  for (const char held : model.balloon_fixed) fixed.push_back(held ? detail::kFixedAll : char(0));
  detail::NewtonOptions newton;
  newton.longest_move = 0.02;
  newton.most_iterations = 500;
  Pressed result;
  result.balloon = model.balloon.vertices;
  for (int step = 1; step <= 10; ++step) {
    detail::Enclosure gas;
    gas.triangles = model.balloon.triangles;
    gas.target = 0.1 * step * pressure;
    const auto at = detail::minimize({&skin, &channel}, fixed, result.balloon, newton, gas);
    result.volume = at.volume;
    result.converged = at.converged;
  }
  result.force = channel.force(result.balloon);
  return result;
}

// The farthest point of one shape from the other: sliding along the planes costs next to nothing.
double apart(const std::vector<Vec3>& from, const std::vector<Vec3>& x,
             const std::vector<Triangle>& triangles) {
  double worst = 0.0;
  for (const Vec3& v : from) {
    double here = std::numeric_limits<double>::max();
    for (const Triangle& f : triangles) {
      const Vec3 &a = x[std::size_t(f[0])], &b = x[std::size_t(f[1])], &c = x[std::size_t(f[2])];
      here = std::min(here, testing::length_of(detail::point_triangle_gap(v, a, b, c), v, a, b, c));
    }
    worst = std::max(worst, here);
  }
  return worst;
}

}  // namespace

Rows against_newton() {
  const SimulationModel model = flat_channel();
  const SimulationOptions options = pressed_in_channel();
  const Pressed step = by_the_step(model, options);
  TriangleMesh now = model.balloon;
  now.vertices = step.balloon;
  const Pressed newton = by_newton(model, options, vertex_areas(now));
  const double shapes = apart(step.balloon, newton.balloon, model.balloon.triangles);
  return {
      {"newton with exact distances: it has converged", newton.converged ? 1.0 : 0.0, 1.0, "",
       true},
      {"newton: enclosed volume", 100.0 * std::abs(step.volume / newton.volume - 1.0), 1.0, "%"},
      {"newton: force on the wall", 100.0 * std::abs(step.force / newton.force - 1.0), 1.0, "%"},
      {"newton: distance of the shapes, of the channel's half width", 100.0 * shapes / kHalf, 1.0,
       "%"}};
}

}  // namespace angio::simulation
