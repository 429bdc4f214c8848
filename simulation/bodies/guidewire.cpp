#include "simulation/bodies/guidewire.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/contact/distance.hpp"

namespace angio::simulation::detail {
namespace {

constexpr std::size_t kLeastNodes = 5;  // clamped at both ends, and one between

// Of a round section, pi d^2 / 4 and pi d^4 / 64.
double area(double diameter) { return 0.25 * units::kPi * diameter * diameter; }
double second_moment(double diameter) { return area(diameter) * diameter * diameter / 16.0; }

// To the nearest point of the rod.
RodTie tie_of(const std::vector<Vec3>& nodes, const Vec3& x, int vertex) {
  RodTie tie{vertex, 0, 0.0};
  double nearest = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double share = -point_segment_gap(x, nodes[i], nodes[i + 1]).w[2];
    const double d = distance(x, nodes[i] + share * (nodes[i + 1] - nodes[i]));
    if (!(d < nearest)) continue;
    nearest = d;
    tie = {vertex, int(i), share};
  }
  return tie;
}

void check_nodes(const std::vector<Vec3>& nodes) {
  if (nodes.size() < kLeastNodes)
    throw InputError("the guidewire has " + std::to_string(nodes.size()) +
                     " nodes (a rod that bends needs " + std::to_string(kLeastNodes) +
                     "). Mesh again with a larger balloon.guidewire_node_count, or use "
                     "guidewire.model = none");
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i)
    if (!(distance(nodes[i], nodes[i + 1]) > 0.0))
      throw InputError("nodes " + std::to_string(i) + " and " + std::to_string(i + 1) +
                       " of the guidewire are in one place (a segment needs a length). Run the "
                       "stage meshing again");
}

}  // namespace

RodSection<double> rod_section(const GuidewireOptions& options) {
  const double shaft = options.shaft_modulus_mpa * units::kPascalPerMegapascal;
  const double wire = options.wire_modulus_mpa * units::kPascalPerMegapascal;
  const double outer = options.shaft_diameter_mm, inner = options.wire_diameter_mm;
  return {shaft * (area(outer) - area(inner)),
          shaft * (second_moment(outer) - second_moment(inner)) + wire * second_moment(inner)};
}

SceneRod make_rod(const SimulationModel& model, const GuidewireOptions& options) {
  SceneRod rod;
  if (options.model == GuidewireModel::none) return rod;
  const std::vector<Vec3>& nodes = model.guidewire;
  check_nodes(nodes);
  rod.count = int(nodes.size());
  rod.radius = 0.5 * options.shaft_diameter_mm;
  rod.section = rod_section(options);
  rod.bend.resize(nodes.size());
  rod.mass.resize(nodes.size());
  rod.held.resize(nodes.size());
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    rod.rest.push_back(distance(nodes[i], nodes[i + 1]));
    const double mass = options.density_g_mm3 * area(options.shaft_diameter_mm) * rod.rest[i];
    rod.mass[i] += 0.5 * mass;
    rod.mass[i + 1] += 0.5 * mass;
  }
  if (options.rest == GuidewireRest::placed)
    for (std::size_t i = 1; i + 1 < nodes.size(); ++i)
      rod.bend[i] = curvature(nodes[i] - nodes[i - 1], nodes[i + 1] - nodes[i]).binormal;
  rod.held[0] = rod.held[1] = 1;
  if (options.tip == GuidewireTip::held) rod.held.back() = rod.held.end()[-2] = 1;
  for (std::size_t v = 0; v < model.balloon_fixed.size(); ++v)
    if (model.balloon_fixed[v])
      rod.ties.push_back(tie_of(nodes, model.balloon.vertices[v], int(v)));
  return rod;
}

}  // namespace angio::simulation::detail
