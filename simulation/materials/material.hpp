#pragma once

#include <string>
#include <vector>

#include "simulation/materials/membrane.hpp"
#include "simulation/simulation.hpp"

/// From the names and charts that users give to the laws that the solvers use.
namespace angio::simulation::detail {

bool is_named_material(const std::string& name);

/// The moduli in force: those given, or the named material's.
MooneyRivlin<double> moduli(const BalloonMaterial& material);
double density(const BalloonMaterial& material);  // [g/mm^3]

/// The membrane of a balloon: the material as it is or, with a chart, a base of the material with
/// fibres around, such that the balloon's free inflation reproduces the chart.
///
/// A balloon's cylindrical part is a closed free tube. With w the base's energy, its stretches l1
/// (around) and l2 (along) obey, at every point of the chart,
///
///     dw/dl2 = p R l1^2 / (2 H)                     gives l2, with l1 = D / D0
///     dw/dl1 + 2 l1 g'(l1^2) = p R l1 l2 / H        gives g' of the fibres at I4 = l1^2
///
/// with D0 = 2 R the unloaded diameter (rest_diameter_mm). g' runs through these values by monotone
/// cubics (Fritsch, Carlson, SIAM J. Numer. Anal. 17 (1980) 238), so that the fibres are convex,
/// and on past the last point along its last chord. The base keeps the material's ratio C1 : C2;
/// its stiffness is the material's or, where the chart is softer, the greatest that leaves g'
/// rising: the membrane is isotropic where the chart is softest and stiffer around than along
/// above, as Geith et al., PLoS ONE 15 (2020) e0234340, saw on polyamide-12 balloons above nominal
/// pressure.
///
/// @throws InputError if no base with a fiftieth of the material's stiffness or more does it
MembraneLaw<double> membrane_law(const BalloonMaterial& material);

/// Stretches of a closed free tube.
struct TubeStretch {
  double around = 1.0, along = 1.0;
};

/// The stretch along the tube that balances its end caps for a given stretch around.
///
/// @param load  p R / H [Pa], >= 0
double tube_stretch_along(const MooneyRivlin<double>& base, double around, double load);

/// Directions of the fibres around the balloon, shape [triangle]: at right angles to the axis and
/// in the triangle's plane; zero where the triangle faces along the axis.
///
/// @param axis  polyline along the balloon (its guidewire); fewer than 2 points: the longest
///              principal axis of the vertices
std::vector<Vec3> hoop_fibres(const std::vector<Triangle>& triangles, const std::vector<Vec3>& rest,
                              const std::vector<Vec3>& axis);

}  // namespace angio::simulation::detail
