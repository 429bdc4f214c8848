#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "simulation/inflate.hpp"
#include "testing/result_table.hpp"
#include "testing/simulation/charts.hpp"
#include "testing/simulation/closed_forms.hpp"
#include "testing/simulation/spheres.hpp"
#include "testing/simulation/thick_tubes.hpp"
#include "testing/simulation/triangles.hpp"

/// The laws that docs/validation.md explains, a row each:
///
///     validation [membrane|sphere|gas|inflate|chart|vbd|wall ...] [--markdown FILE]
///
/// @return 1 if a row misses its bar
namespace angio::simulation {
namespace {

using namespace detail;
using testing::closed_tube;

struct Row {
  std::string law;
  double value;  ///< as large as it got
  double bar;    ///< and may get
  const char* unit;
};
using Rows = std::vector<Row>;

// Energy, gradient and Hessian of single triangles
// -------------------------------------------------

struct Worst {
  double gradient = 0.0, hessian = 0.0, force = 0.0, torque = 0.0, turned = 0.0;
  int not_finite = 0;
};

void turn_check(const testing::Element<double>& t, const MembraneLaw<double>& law, double size,
                const testing::Whole<double>& at, Worst& worst) {
  const double c = std::cos(1.1), s = std::sin(1.1);
  const auto turned = [&](const Vec3& p) {
    const Vec3 q{c * p.x - s * p.y, s * p.x + c * p.y, p.z};
    return Vec3{q.x, s * q.y - c * q.z, c * q.y + s * q.z};
  };
  testing::Element<double> moved = t;
  for (Vec3& x : moved.x) x = turned(x);
  const testing::Whole<double> there = testing::whole(moved, 0, law);
  Vec3 force, torque;
  for (int v = 0; v < 3; ++v) {
    const Vec3 g{at.gradient(3 * v), at.gradient(3 * v + 1), at.gradient(3 * v + 2)};
    const Vec3 h{there.gradient(3 * v), there.gradient(3 * v + 1), there.gradient(3 * v + 2)};
    force += g;
    torque += cross(t.x[v] - t.x[0], g);
    worst.turned = std::max(worst.turned, norm(h - turned(g)) / size);
  }
  worst.force = std::max(worst.force, norm(force) / size);
  worst.torque = std::max(worst.torque, norm(torque) / size);
}

void check_triangle(double l1, double l2, double aspect, unsigned seed, Worst& worst) {
  const auto t = testing::stretched(l1, l2, aspect, seed);
  for (const bool relaxed : {false, true})
    for (const bool fibres : {false, true}) {
      // The relaxed energy's curvature jumps between its regimes: no difference there.
      const double width = 1.0 / std::sqrt(std::max(l1, l2));
      if (relaxed &&
          (std::abs(std::max(l1, l2) - 1.0) < 1e-4 || std::abs(std::min(l1, l2) - width) < 1e-4))
        continue;
      const auto numeric = testing::differences(t, testing::law_of<long double>(relaxed, fibres));
      const MembraneLaw<double> law = testing::law_of<double>(relaxed, fibres);
      const auto at = testing::whole(t, int(seed % 3), law);
      if (!at.gradient.allFinite() || !at.hessian.allFinite()) ++worst.not_finite;
      const double force =
          std::max(double(numeric.gradient.norm()), 1e-3 * testing::force_scale(aspect));
      const double stiffness =
          std::max(double(numeric.hessian.norm()), 1e-3 * testing::stiffness_scale(aspect));
      const auto wrong_by = [](const auto& a, const auto& b) {
        return double((a.template cast<long double>() - b).norm());
      };
      worst.gradient = std::max(worst.gradient, wrong_by(at.gradient, numeric.gradient) / force);
      worst.hessian = std::max(worst.hessian, wrong_by(at.hessian, numeric.hessian) / stiffness);
      turn_check(t, law, std::max(testing::force_scale(aspect), at.gradient.norm()), at, worst);
    }
}

Rows membrane() {
  Worst worst;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> stretch(0.4, 3.0), aspect(0.05, 1.0);
  for (unsigned n = 0; n < 500; ++n)
    check_triangle(stretch(random), stretch(random), aspect(random), n, worst);
  for (const double flat : {1.0, 0.02, 0.005})  // rest, equal stretches, slivers, nearly a line
    for (const auto& [l1, l2] : {std::pair{1.0, 1.0}, {1.5, 1.5}, {0.8, 0.8}, {1.2, 0.05}})
      check_triangle(l1, l2, flat, 7u, worst);
  return {{"membrane: gradient against differences, relative", worst.gradient, 1e-6, ""},
          {"membrane: Hessian against differences, relative", worst.hessian, 1e-6, ""},
          {"membrane: states that are not finite", double(worst.not_finite), 0.0, ""},
          {"membrane: net force, relative", worst.force, 1e-10, ""},
          {"membrane: net torque, relative", worst.torque, 1e-10, ""},
          {"membrane: change by a rotation, relative", worst.turned, 1e-10, ""}};
}

// Spheres
// ------------------------------------------------------------------------------------------

std::map<double, double> sphere_errors(int n) {
  const testing::Sphere sphere(n);
  std::vector<Vec3> x = sphere.mesh.vertices;
  std::map<double, double> errors;
  for (const double l : {1.05, 1.1, 1.2, 1.5, 2.0, 2.5, 3.0}) {
    const auto result =
        sphere.solve(Enclosure::Control::pressure, testing::sphere_pressure(l, 1.5), x);
    errors[l] = result.converged ? std::cbrt(result.volume / sphere.volume) / l - 1.0 : 1.0;
  }
  return errors;
}

Rows sphere() {
  Rows rows;
  std::array<std::map<double, double>, 2> errors{sphere_errors(7), sphere_errors(14)};
  for (int i = 0; i < 2; ++i) {
    double low = 0.0, high = 0.0;
    for (const auto& [l, error] : errors[std::size_t(i)])
      (l < 1.21 ? low : high) = std::max(l < 1.21 ? low : high, std::abs(error));
    const std::string name = "sphere, " + std::to_string(i == 0 ? 492 : 1962) + " vertices: ";
    rows.push_back({name + "stretch, 1.05 to 1.2", 100.0 * low, 0.15, "%"});
    rows.push_back({name + "stretch, 1.5 to 3", 100.0 * high, 0.6, "%"});
  }
  double off = 0.0;
  for (const auto& [l, error] : errors[0])
    off = std::max(off, std::abs(error / errors[1].at(l) / 4.0 - 1.0));
  rows.push_back({"sphere: error ratio of the two meshes against 4", 100.0 * off, 5.0, "%"});
  return rows;
}

Rows gas() {
  const testing::Sphere sphere(7);
  const double outside = units::kPascalPerAtm + 1e4;
  double off = 0.0;
  for (const double fill : {0.9, 1.0, 2.0, 5.0, 10.0}) {
    std::vector<Vec3> x = sphere.mesh.vertices;
    const double target = fill * outside * sphere.volume;
    const auto r = sphere.solve(Enclosure::Control::gas, target, x, outside);
    off = std::max(off,
                   r.converged ? std::abs((r.pressure + outside) * r.volume / target - 1.0) : 1.0);
  }
  std::vector<Vec3> x = sphere.mesh.vertices;
  double work = 0.0, volume = sphere.volume, pressure = 0.0, worst = 0.0, most = 0.0;
  const int steps = 24;
  for (int k = 1; k <= 2 * steps; ++k) {
    const double l = 1.0 + (k <= steps ? k : 2 * steps - k) / double(steps);
    const auto r = sphere.solve(Enclosure::Control::volume, l * l * l * sphere.volume, x);
    work += 0.5 * (pressure + r.pressure) * (r.volume - volume);
    volume = r.volume;
    pressure = r.pressure;
    most = std::max(most, r.energy);
    worst = std::max(worst, std::abs(work - r.energy));
  }
  return {
      {"gas: p V = Q, relative", off, 1e-6, ""},
      {"gas: work of pressure against energy, to l = 2 and back", 100.0 * worst / most, 1.0, "%"}};
}

// Free inflation
// -----------------------------------------------------------------------------------

FreeBalloon rubber(BalloonEnds ends) {
  FreeBalloon balloon;
  balloon.material.name = "polyurethane";
  balloon.ends = ends;
  return balloon;
}

double atm_of_load(const FreeBalloon& balloon, double load_mpa) {
  return units::atm_from_pascal(units::pascal_from_megapascal(load_mpa) * balloon.material.wall_mm /
                                balloon.radius_mm);
}

// The worst error of the diameter [%] under the pressures that stretch the balloon so.
double diameter_error(const FreeBalloon& balloon, const std::vector<double>& stretches,
                      const std::function<double(double)>& load_mpa) {
  InflateOptions options;
  for (const double l : stretches)
    options.pressures_atm.push_back(atm_of_load(balloon, load_mpa(l)));
  const auto points = inflate(balloon, options);
  double worst = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i)
    worst = std::max(
        worst, points[i].converged
                   ? std::abs(0.5 * points[i].diameter_mm / balloon.radius_mm / stretches[i] - 1.0)
                   : 1.0);
  return 100.0 * worst;
}

double limit_error() {
  const FreeBalloon tube = rubber(BalloonEnds::tube);
  InflateOptions options;
  for (double l = 2.3; l < 2.7; l += 0.01)
    options.volumes_mm3.push_back(units::kPi * tube.radius_mm * tube.radius_mm * tube.length_mm *
                                  l * l * 0.8226);
  double most = 0.0;
  for (const InflationPoint& point : inflate(tube, options))
    if (point.converged) most = std::max(most, point.pressure_atm);
  return 100.0 * std::abs(most / atm_of_load(tube, 8.253) - 1.0);
}

Rows inflation() {
  const auto closed = [](double l) { return closed_tube(l).load_mpa; };
  const auto fixed = [](double l) {
    return 2.0 * (testing::kC1 + testing::kC2) * (1.0 - std::pow(l, -4));
  };
  return {
      {"closed capsule against the free tube: diameter, 1.05 to 1.3",
       diameter_error(rubber(BalloonEnds::hemispheres), {1.05, 1.1, 1.2, 1.3}, closed), 0.1, "%"},
      {"piece of a closed tube: diameter, 1.05 to 2",
       diameter_error(rubber(BalloonEnds::tube), {1.05, 1.1, 1.2, 1.3, 1.5, 2.0}, closed), 0.2,
       "%"},
      {"tube of fixed length: diameter, 1.05 to 2.4",
       diameter_error(rubber(BalloonEnds::fixed_length), {1.05, 1.1, 1.3, 1.6, 2.0, 2.4}, fixed),
       0.2, "%"},
      {"limit point 8.253 MPa H / R under volume control", limit_error(), 0.5, "%"}};
}

FreeBalloon charted_balloon(const testing::Charted& charted) {
  FreeBalloon balloon;
  balloon.material.name = charted.material;
  balloon.material.wall_mm = charted.wall_mm;
  balloon.material.chart = charted.chart;
  balloon.radius_mm = 0.5 * rest_diameter_mm(charted.chart);
  return balloon;
}

Rows charts() {
  Rows rows;
  for (const testing::Charted& charted : testing::charted_balloons()) {
    const FreeBalloon balloon = charted_balloon(charted);
    InflateOptions options;
    for (const ChartPoint& point : charted.chart)
      options.pressures_atm.push_back(point.pressure_atm);
    double worst = 0.0;
    const auto points = inflate(balloon, options);
    for (std::size_t i = 0; i < points.size(); ++i)
      worst =
          std::max(worst, points[i].converged
                              ? std::abs(points[i].diameter_mm / charted.chart[i].diameter_mm - 1.0)
                              : 1.0);
    rows.push_back({std::string("chart, ") + charted.name + ": diameter at its points",
                    100.0 * worst, 1.5, "%"});
  }
  return rows;
}

// Vertex block descent against Newton's method.
Rows descent() {
  Rows rows;
  std::vector<std::pair<std::string, FreeBalloon>> balloons{
      {"polyurethane, to a stretch of 1.2", rubber(BalloonEnds::hemispheres)}};
  std::vector<InflateOptions> loads(1);
  for (const double load : {1.66, 2.945, 4.751})
    loads[0].pressures_atm.push_back(atm_of_load(balloons[0].second, load));
  for (const testing::Charted& charted : testing::charted_balloons()) {
    if (std::string(charted.name).find("_compliant") == std::string::npos) continue;
    balloons.emplace_back(charted.name, charted_balloon(charted));
    loads.emplace_back();
    for (const ChartPoint& point : charted.chart)
      loads.back().pressures_atm.push_back(point.pressure_atm);
  }
  for (std::size_t i = 0; i < balloons.size(); ++i) {
    const auto newton = inflate(balloons[i].second, loads[i]);
    loads[i].solver = InflateSolver::vbd;
    loads[i].backend = Backend::cpu;
    const auto vbd = inflate(balloons[i].second, loads[i]);
    double worst = 0.0;
    for (std::size_t k = 0; k < vbd.size(); ++k)
      worst = std::max(worst, vbd[k].converged
                                  ? std::abs(vbd[k].diameter_mm / newton[k].diameter_mm - 1.0)
                                  : 1.0);
    rows.push_back(
        {"vbd against newton, " + balloons[i].first + ": diameter", 100.0 * worst, 0.1, "%"});
  }
  return rows;
}

// The layered wall alone
// ----------------------

double worst_tube(const WallRegionMaterial& material, const std::vector<double>& inner_radii) {
  double worst = 0.0;
  for (const double inner : inner_radii) {
    const testing::TubeError e = testing::tube_error(material, inner, 48, {1.0, 1.0, 1.0});
    if (!(std::isfinite(e.inner) && std::isfinite(e.outer))) return e.inner;
    worst = std::max({worst, std::abs(e.inner), std::abs(e.outer)});
  }
  return 100.0 * worst;
}

// A stenosed tube of the coronary's layers: how far from the shape that was seen it comes to rest.
double prestressed_distance() {
  TubeWall shape = testing::round_tube(1.2, 1.75, 20, 10, 4.0);
  shape.rim = 1;
  shape.inner_radius_mm = [](double a, double z) {
    return 1.2 - 0.6 * std::exp(-2.0 * (z - 2.0) * (z - 2.0)) * (1.0 + 0.3 * std::cos(a));
  };
  const WallSolution seen = prestress_wall(make_tube_wall(shape), WallOptions{});
  return seen.converged ? seen.displacement_mm : std::nan("");
}

Rows layered_wall() {
  return {{"thick tube, neo-Hookean, 3 elements, to 1.1 and 1.4 radii: displacement",
           worst_tube(testing::neo_hookean(20.0, 1000.0), {1.1, 1.4}), 1.0, "%"},
          {"thick tube, Holzapfel-Gasser-Ogden, 3 elements, to 1.1 and 1.3 radii: displacement",
           worst_tube(testing::kFibered, {1.1, 1.3}), 1.0, "%"},
          {"pre-stress: the loaded shape off the one that was seen", prestressed_distance(), 0.01,
           "mm"}};
}

const std::vector<std::pair<std::string, Rows (*)()>> kGroups{
    {"membrane", membrane}, {"sphere", sphere}, {"gas", gas},          {"inflate", inflation},
    {"chart", charts},      {"vbd", descent},   {"wall", layered_wall}};

int print_groups(const std::vector<std::string>& names, benchmarks::ResultTable& results) {
  using benchmarks::formatted;
  int failures = 0;
  results.columns({"law", "bar", "value", ""});
  for (const auto& [name, rows] : kGroups) {
    if (!names.empty() && std::find(names.begin(), names.end(), name) == names.end()) continue;
    for (const Row& row : rows()) {
      const bool pass = row.value <= row.bar;  // false for NaN
      failures += pass ? 0 : 1;
      results.row({row.law, formatted("%.3g %s", row.bar, row.unit),
                   formatted("%.2g %s", row.value, row.unit), pass ? "pass" : "FAIL"});
    }
  }
  return failures;
}

}  // namespace
}  // namespace angio::simulation

int main(int count, char** arguments) {
  try {
    angio::benchmarks::ResultTable results("Membrane, gas, free inflation and layered wall", count,
                                           arguments);
    const std::vector<std::string> names(arguments + 1, arguments + count);
    for (const std::string& name : names)
      if (std::none_of(angio::simulation::kGroups.begin(), angio::simulation::kGroups.end(),
                       [&](const auto& group) { return group.first == name; })) {
        std::fprintf(stderr,
                     "no group \"%s\". Use membrane, sphere, gas, inflate, chart, vbd or wall\n",
                     name.c_str());
        return 64;
      }
    const int failures = angio::simulation::print_groups(names, results);
    results.write();
    return failures == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 70;
  }
}
