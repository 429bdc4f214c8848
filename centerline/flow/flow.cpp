#include "centerline/flow/flow.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "centerline/flow/branch_losses.hpp"
#include "core/error.hpp"
#include "core/require.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr double kPascalPerMmhg = 133.322387415;  // conventional millimetre of mercury
constexpr double kMm3PerSPerMlPerMin = 1000.0 / 60.0;

/// A branch as the solver sees it: p_in - p_out = friction Q + expansion Q |Q| [Pa, mm^3/s].
struct Resistor {
  int parent = -1;
  std::vector<std::size_t> daughters;
  BranchLosses losses;
  double friction = 0.0, expansion = 0.0;
  double share = 0.0;   ///< of the inlet's flow, where all is healthy
  double behind = 0.0;  ///< resistance behind an outlet [Pa s/mm^3]
  double flow = 0.0;    ///< [mm^3/s]
};

/// What is not as it was measured.
struct Variation {
  double radius = 0.0;  ///< added to each that was measured [mm]
  double flow = 1.0;    ///< factor
};

void check(const FlowTree& tree) {
  if (tree.branches.empty())
    throw InputError("there is no vessel for blood to flow in (the tree is empty). Run centerline");
  for (std::size_t b = 0; b < tree.branches.size(); ++b) {
    const FlowBranch& branch = tree.branches[b];
    const auto refuse = [&](const char* fault) {
      throw InputError("branch " + std::to_string(b) + " of the tree " + fault +
                       ", so its flow cannot be found. Run centerline again");
    };
    const std::size_t count = branch.abscissa.size();
    if (count < 2 || branch.radius.size() != count || branch.healthy.size() != count)
      refuse("has too few points");
    if (branch.parent >= int(b) || (branch.parent < 0) != (b == 0))
      refuse("does not follow the one before it");
    for (std::size_t i = 0; i < count; ++i) {
      if (!std::isfinite(branch.abscissa[i]) ||
          (i > 0 && branch.abscissa[i] < branch.abscissa[i - 1]))
        refuse("runs backwards");
      if (!(branch.radius[i] >= 0.0) || !std::isfinite(branch.radius[i]))
        refuse("has a radius that is none");
      if (!(branch.healthy[i] > 0.0) || !std::isfinite(branch.healthy[i]))
        refuse("has no healthy radius");
    }
  }
}

/// Measured radii that are wrong alike; a throat does not close.
FlowBranch widened(FlowBranch branch, double by) {
  constexpr double kLeast = 0.1;  // of what was measured
  for (double& r : branch.radius)
    if (r > 0.0) r = std::max(r + by, kLeast * r);
  return branch;
}

std::vector<Resistor> make_network(const FlowTree& tree, const FlowOptions& options,
                                   const Variation& variation) {
  std::vector<Resistor> network(tree.branches.size());
  for (std::size_t b = 1; b < network.size(); ++b) {
    network[b].parent = tree.branches[b].parent;
    network[std::size_t(network[b].parent)].daughters.push_back(b);
  }
  const double viscosity = 1e-3 * options.viscosity_mpa_s;    // [g/(mm s)]
  const double density = 1e-9 * 1e3 * options.density_kg_m3;  // [g/mm^3]
  for (std::size_t b = 0; b < network.size(); ++b) {
    Resistor& resistor = network[b];
    const FlowBranch branch = widened(tree.branches[b], variation.radius);
    resistor.losses = branch_losses(branch.abscissa, filled_radii(branch),
                                    resistor.daughters.empty() ? 0.0 : branch.healthy.back());
    for (double& part : resistor.losses.friction) part *= viscosity;
    for (double& part : resistor.losses.expansion)
      part *= 0.5 * options.expansion_coefficient * density;
    resistor.friction = resistor.losses.friction.back();
    resistor.expansion = resistor.losses.expansion.back();
  }
  return network;
}

/// Healthy flows, and the resistances behind the outlets that they need. @param inlet [mm^3/s]
void share_out(std::vector<Resistor>& network, const FlowTree& tree, const FlowOptions& options,
               double inlet) {
  const auto weight = [&](std::size_t b) {
    return std::pow(tree.branches[b].healthy.front(), options.branching_exponent);
  };
  network.front().share = 1.0;
  for (Resistor& resistor : network) {
    double sum = 0.0;
    for (const std::size_t d : resistor.daughters) sum += weight(d);
    for (const std::size_t d : resistor.daughters)
      network[d].share = resistor.share * weight(d) / sum;
    resistor.flow = resistor.share * inlet;
    resistor.behind = kPascalPerMmhg *
                      (options.aortic_pressure_mmhg - options.venous_pressure_mmhg) / resistor.flow;
  }
}

/// All that lies behind a place, its laws made linear: the flow there is conductance (p -
/// pressure).
struct Behind {
  double conductance = 0.0, pressure = 0.0;
};

/// Daughters side by side, or the small vessels of an outlet.
Behind behind_end(const Resistor& r, const std::vector<Behind>& inlets, double venous) {
  if (r.daughters.empty()) return {1.0 / r.behind, venous};
  double conductance = 0.0, current = 0.0;
  for (const std::size_t d : r.daughters) {
    conductance += inlets[d].conductance;
    current += inlets[d].conductance * inlets[d].pressure;
  }
  return {conductance, current / conductance};
}

/// One Newton step, up the tree and down again. @return the greatest relative change of a flow
double step(std::vector<Resistor>& network, double aortic, double venous) {
  std::vector<Behind> ends(network.size()), inlets(network.size());
  for (std::size_t b = network.size(); b-- > 0;) {
    const Resistor& r = network[b];
    ends[b] = behind_end(r, inlets, venous);
    const double slope = r.friction + 2.0 * r.expansion * std::abs(r.flow);
    inlets[b] = {1.0 / (1.0 / ends[b].conductance + slope),
                 ends[b].pressure - r.expansion * r.flow * std::abs(r.flow)};
  }
  double change = 0.0;
  for (std::size_t b = 0; b < network.size(); ++b) {
    Resistor& r = network[b];
    const auto p = std::size_t(std::max(r.parent, 0));
    const double pressure =
        r.parent < 0 ? aortic : ends[p].pressure + network[p].flow / ends[p].conductance;
    const double flow = inlets[b].conductance * (pressure - inlets[b].pressure);
    change = std::max(change, std::abs(flow - r.flow) / std::abs(flow));
    r.flow = flow;
  }
  return change;
}

/// At each point of a branch [mmHg]. @param inlet  [Pa]
std::vector<double> pressures(const Resistor& r, double inlet) {
  std::vector<double> pressure(r.losses.friction.size());
  for (std::size_t i = 0; i < pressure.size(); ++i)
    pressure[i] = (inlet - r.losses.friction[i] * r.flow -
                   r.losses.expansion[i] * r.flow * std::abs(r.flow)) /
                  kPascalPerMmhg;
  return pressure;
}

FlowSolution solve(const FlowTree& tree, const FlowOptions& options, double healthy_inlet,
                   const Variation& variation) {
  constexpr int kMostSteps = 200;
  constexpr double kEnough = 1e-12;
  std::vector<Resistor> network = make_network(tree, options, variation);
  share_out(network, tree, options, variation.flow * healthy_inlet);
  const double aortic = kPascalPerMmhg * options.aortic_pressure_mmhg;
  const double venous = kPascalPerMmhg * options.venous_pressure_mmhg;
  FlowSolution solution;
  for (int i = 0; i < kMostSteps && !solution.converged; ++i)
    solution.converged = step(network, aortic, venous) < kEnough;
  for (const Resistor& r : network) {
    const double inlet =
        r.parent < 0 ? aortic
                     : kPascalPerMmhg * solution.pressure_mmhg[std::size_t(r.parent)].back();
    solution.pressure_mmhg.push_back(pressures(r, inlet));
    solution.flow_ml_min.push_back(r.flow / kMm3PerSPerMlPerMin);
  }
  return solution;
}

}  // namespace

void FlowOptions::validate() const {
  require_within("flow.aortic_pressure_mmhg", aortic_pressure_mmhg, 40.0, 200.0);
  require_within("flow.venous_pressure_mmhg", venous_pressure_mmhg, 0.0, 30.0);
  require_within("flow.inlet_flow_ml_min", inlet_flow_ml_min, 0.0, 2000.0);
  require_within("flow.hyperaemic_velocity_m_s", hyperaemic_velocity_m_s, 0.05, 2.0);
  require_within("flow.branching_exponent", branching_exponent, 2.0, 4.0);
  require_within("flow.viscosity_mpa_s", viscosity_mpa_s, 0.5, 20.0);
  require_within("flow.density_kg_m3", density_kg_m3, 900.0, 1200.0);
  require_within("flow.expansion_coefficient", expansion_coefficient, 0.0, 5.0);
  if (diameter_error_mm) require_within("flow.diameter_error_mm", *diameter_error_mm, 0.0, 2.0);
  require_within("flow.flow_error_percent", flow_error_percent, 0.0, 90.0);
}

FlowResult solve_flow(const FlowTree& tree, const FlowOptions& options, double diameter_error_mm) {
  options.validate();
  check(tree);
  const double error = options.diameter_error_mm.value_or(diameter_error_mm);
  if (!(error >= 0.0) || !std::isfinite(error))
    throw InputError("the error of diameters is no length. Give flow.diameter_error_mm");
  const double radius = tree.branches.front().healthy.front();
  const double velocity = 1e3 * options.hyperaemic_velocity_m_s;  // [mm/s]
  const double inlet = options.inlet_flow_ml_min > 0.0
                           ? options.inlet_flow_ml_min * kMm3PerSPerMlPerMin
                           : velocity * units::kPi * radius * radius;
  const double share = 0.01 * options.flow_error_percent;
  FlowResult result;
  result.inlet_flow_ml_min = inlet / kMm3PerSPerMlPerMin;
  result.inlet_diameter_mm = 2.0 * radius;
  result.best = solve(tree, options, inlet, {});
  const std::array<Variation, 4> variations{
      {{-0.5 * error, 1.0}, {0.5 * error, 1.0}, {0.0, 1.0 - share}, {0.0, 1.0 + share}}};
  for (std::size_t v = 0; v < variations.size(); ++v)
    result.varied[v] = solve(tree, options, inlet, variations[v]);
  return result;
}

Estimate estimate(const FlowResult& result,
                  const std::function<double(const FlowSolution&)>& number) {
  const double value = number(result.best);
  double above = 0.0, below = 0.0;
  for (std::size_t cause = 0; cause < 2; ++cause) {
    const double a = number(result.varied[2 * cause]) - value,
                 b = number(result.varied[2 * cause + 1]) - value;
    const double up = std::max({a, b, 0.0}), down = std::min({a, b, 0.0});
    above += up * up;
    below += down * down;
  }
  return {value, value - std::sqrt(below), value + std::sqrt(above)};
}

}  // namespace angio::centerline
