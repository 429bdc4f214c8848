#include "simulation/wall.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/newton/wall_terms.hpp"

namespace angio::simulation {
namespace {

using namespace detail;

// Newton's method for the balance under a pressure [Pa]; x is moved.
NewtonResult balance(const LayeredWall& wall, const SolidModel& model, double pressure,
                     std::vector<Vec3>& x) {
  const SolidTerm solid(model);
  const FoundationTerm foundation(model.foundation, wall.vertices);
  // A stiff bulk's rounding keeps a small load's imbalance from falling much further.
  constexpr double kSought = 1e-7, kEnough = 1e-5;
  NewtonResult result = minimize({&solid, &foundation}, wall.fixed, x,
                                 NewtonOptions{.most_iterations = 60, .tolerance = kSought},
                                 lumen_enclosure(wall, pressure));
  result.converged = result.residual <= kEnough;
  return result;
}

double largest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double most = 0.0;
  for (std::size_t v = 0; v < a.size(); ++v) most = std::max(most, distance(a[v], b[v]));
  return most;
}

}  // namespace

WallState unloaded_state(const LayeredWall& wall) {
  WallState state;
  state.vertices = wall.vertices;
  state.prestress.assign(kWedgePoints * wall.wedges.size(), Mat3::identity());
  state.plastic = state.prestress;
  state.plastic_strain.assign(state.plastic.size(), 0.0);
  return state;
}

WallSolution solve_wall(const LayeredWall& wall, const WallOptions& options, const WallState& start,
                        double pressure_kpa, double time_s) {
  constexpr int kMostRounds = 400;
  constexpr double kClose = 1e-8;  // of the equivalent plastic strain
  options.validate();
  check_wall(wall, options);
  SolidModel model = make_solid_model(wall, options);
  WallSolution out;
  out.state = start;
  set_memory(out.state, model);
  bool settled = false;
  for (int round = 0; round < kMostRounds && !settled; ++round) {
    const NewtonResult result =
        balance(wall, model, units::kPascalPerKilopascal * pressure_kpa, out.state.vertices);
    out.iterations += result.iterations;
    out.residual = result.residual;
    out.converged = result.converged;
    if (!result.converged) break;
    // What creeps does so once, in the given time; what yields at once does so until it is still.
    settled = flow(model, out.state, round == 0 ? time_s : 0.0) <= kClose;
  }
  out.converged = out.converged && settled;
  out.displacement_mm = largest_distance(out.state.vertices, wall.vertices);
  return out;
}

WallFields wall_fields(const LayeredWall& wall, const WallOptions& options,
                       const WallState& state) {
  SolidModel model = make_solid_model(wall, options);
  set_memory(state, model);
  return fields(model, wall, state);
}

}  // namespace angio::simulation
