#include "simulation/materials/material.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::simulation::detail {
namespace {

struct Named {
  const char* name;
  double c1_mpa, c2_mpa, density_g_mm3;
};

// An incompressible neo-Hookean solid has E = 6 C1.
constexpr Named kNamed[] = {
    // E = 900 MPa (De Beule 2008, Gervaso 2008).
    {"pa12", 150.0, 0.0, 1.1e-3},
    // Biaxially drawn film: E = 4500 MPa both ways (Mitsubishi Polyester Film, comparative data);
    // 4800 to 5000 MPa and 1.39 g/cm3 (Mylar, physical-thermal properties). Drawing a balloon
    // differs, hence representative.
    {"pet", 750.0, 0.0, 1.39e-3},
    // Seed paper, table 1, in MPa.
    {"polyurethane", 1.031, 3.69, 1.07e-3},
};

const Named* find_named(const std::string& name) {
  for (const Named& known : kNamed)
    if (name == known.name) return &known;
  return nullptr;
}

constexpr double kLeastBaseShare = 0.02;
constexpr double kBaseStep = 0.99;      // of the search for the stiffest base
constexpr double kStraightStart = 0.1;  // of the way to the first point the fibres' curve bends

// The nodes of g' for a base: none if g' would not rise from node to node.
struct Slopes {
  std::vector<double> i4, slope;
};

bool find_slopes(const MooneyRivlin<double>& base, const BalloonMaterial& material, double rest,
                 Slopes& out) {
  out = {{1.0}, {0.0}};
  for (const ChartPoint& point : material.chart) {
    if (point.pressure_atm == 0.0) continue;
    const double load = units::pascal_from_atm(point.pressure_atm) * 0.5 * rest / material.wall_mm;
    const double l1 = point.diameter_mm / rest, l2 = tube_stretch_along(base, l1, load);
    const double by_l1 = 2.0 * base.c1 * (l1 - std::pow(l1, -3) * std::pow(l2, -2)) +
                         2.0 * base.c2 * (l1 * l2 * l2 - std::pow(l1, -3));
    const double slope = (load * l1 * l2 - by_l1) / (2.0 * l1);
    if (!(slope >= out.slope.back())) return false;
    out.i4.push_back(l1 * l1);
    out.slope.push_back(slope);
  }
  return true;
}

// The curve's slope at an inner node: the harmonic mean that keeps it monotone.
double curvature_between(double h0, double s0, double h1, double s1) {
  if (!(s0 > 0.0) || !(s1 > 0.0)) return 0.0;
  const double w0 = 2.0 * h1 + h0, w1 = h1 + 2.0 * h0;
  return (w0 + w1) / (w0 / s0 + w1 / s1);
}

FibreLaw<double> fibre_law(const Slopes& nodes) {
  Slopes all = nodes;  // with a node where the curve has got straight after its soft start
  all.i4.insert(all.i4.begin() + 1, 1.0 + kStraightStart * (nodes.i4[1] - 1.0));
  all.slope.insert(all.slope.begin() + 1, kStraightStart * nodes.slope[1]);
  FibreLaw<double> law;
  law.count = int(all.i4.size());
  std::vector<double> step, chord;
  for (std::size_t n = 0; n + 1 < all.i4.size(); ++n) {
    step.push_back(all.i4[n + 1] - all.i4[n]);
    chord.push_back((all.slope[n + 1] - all.slope[n]) / step[n]);
  }
  for (std::size_t n = 0; n < all.i4.size(); ++n) {
    law.i4[n] = all.i4[n];
    law.slope[n] = all.slope[n];
    // Flat at the unloaded length: the Hessian has no step there.
    if (n == 0)
      law.curvature[n] = 0.0;
    else if (n + 1 < all.i4.size())
      law.curvature[n] = curvature_between(step[n - 1], chord[n - 1], step[n], chord[n]);
    else
      law.curvature[n] = chord[n - 1];
    if (n == 0) continue;
    EnergyDensity<double> end;  // the last piece, up to this node
    FibreLaw<double> piece = law;
    piece.count = int(n) + 1;
    add_fibres(piece, std::nextafter(law.i4[n], 0.0), end);
    law.value[n] = end.value;
  }
  return law;
}

MembraneLaw<double> chart_law(const BalloonMaterial& material) {
  validate_chart(material.chart, material.name);
  const double rest = rest_diameter_mm(material.chart);
  const MooneyRivlin<double> full = moduli(material);
  for (double share = 1.0; share >= kLeastBaseShare; share *= kBaseStep) {
    const MooneyRivlin<double> base{share * full.c1, share * full.c2};
    Slopes slopes;
    if (find_slopes(base, material, rest, slopes)) return {base, fibre_law(slopes), false};
  }
  char text[300];
  std::snprintf(
      text, sizeof text,
      "the chart gives way too much for a wall of %g mm of %.40s (its diameter grows "
      "faster with pressure than a membrane fifty times softer allows). Check the chart's "
      "units, or give a softer material or a thinner wall",
      material.wall_mm, material.name.c_str());
  throw InputError(text);
}

// The direction of the longest extent.
Vec3 principal_axis(const std::vector<Vec3>& points) {
  Vec3 centre;
  for (const Vec3& p : points) centre += (1.0 / double(points.size())) * p;
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) {
    const Eigen::Vector3d q(p.x - centre.x, p.y - centre.y, p.z - centre.z);
    moment += q * q.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moment);
  const Eigen::Vector3d longest = eigen.eigenvectors().col(2);
  return {longest.x(), longest.y(), longest.z()};
}

// The direction of the polyline's segment nearest to a point.
Vec3 tangent_near(const std::vector<Vec3>& line, const Vec3& point) {
  double best = std::numeric_limits<double>::infinity();
  Vec3 tangent;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vec3 d = line[i] - line[i - 1];
    const double squared = norm_squared(d);
    if (!(squared > 0.0)) continue;
    const double t = std::clamp(dot(point - line[i - 1], d) / squared, 0.0, 1.0);
    const double away = norm_squared(point - line[i - 1] - t * d);
    if (away < best) {
      best = away;
      tangent = d / std::sqrt(squared);
    }
  }
  return tangent;
}

}  // namespace

bool is_named_material(const std::string& name) { return find_named(name) != nullptr; }

MooneyRivlin<double> moduli(const BalloonMaterial& material) {
  const Named* known = find_named(material.name);
  if (material.c1_mpa > 0.0 || known == nullptr)
    return {units::pascal_from_megapascal(material.c1_mpa),
            units::pascal_from_megapascal(material.c2_mpa)};
  return {units::pascal_from_megapascal(known->c1_mpa),
          units::pascal_from_megapascal(known->c2_mpa)};
}

double density(const BalloonMaterial& material) {
  if (material.density_g_mm3 > 0.0) return material.density_g_mm3;
  const Named* known = find_named(material.name);
  return known != nullptr ? known->density_g_mm3 : 1.1e-3;
}

MembraneLaw<double> membrane_law(const BalloonMaterial& material) {
  return material.chart.empty() ? MembraneLaw<double>{moduli(material), {}, false}
                                : chart_law(material);
}

double tube_stretch_along(const MooneyRivlin<double>& base, double around, double load) {
  const double l1 = around, target = 0.5 * load * l1 * l1;
  double low = 1e-3, high = 1e3;  // dw/dl2 rises
  for (int i = 0; i < 100; ++i) {
    const double l2 = 0.5 * (low + high), cubed = std::pow(l2, -3);
    const double by_l2 =
        2.0 * base.c1 * (l2 - cubed / (l1 * l1)) + 2.0 * base.c2 * (l1 * l1 * l2 - cubed);
    (by_l2 < target ? low : high) = l2;
  }
  return 0.5 * (low + high);
}

std::vector<Vec3> hoop_fibres(const std::vector<Triangle>& triangles, const std::vector<Vec3>& rest,
                              const std::vector<Vec3>& axis) {
  const bool has_line = axis.size() > 1;
  const Vec3 straight = has_line ? Vec3{} : principal_axis(rest);
  std::vector<Vec3> fibres;
  for (const auto& [a, b, c] : triangles) {
    const Vec3 &p = rest[std::size_t(a)], &q = rest[std::size_t(b)], &r = rest[std::size_t(c)];
    const Vec3 normal = normalized(cross(q - p, r - p));
    const Vec3 along = has_line ? tangent_near(axis, (1.0 / 3.0) * (p + q + r)) : straight;
    const Vec3 around = cross(along, normal);
    fibres.push_back(norm(around) > 1e-3 ? normalized(around) : Vec3{});
  }
  return fibres;
}

}  // namespace angio::simulation::detail
