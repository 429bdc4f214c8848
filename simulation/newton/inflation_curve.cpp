#include "simulation/newton/inflation_curve.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "simulation/materials/material.hpp"
#include "simulation/newton/equilibria.hpp"
#include "simulation/pbd/membrane_solver.hpp"

namespace angio::simulation::detail {
namespace {

using Control = Enclosure::Control;

const std::vector<Vec3> kAxis{{0, 0, -1}, {0, 0, 1}};

constexpr double kMostGrowth = 1.25;  // of the volume in one step; more may be a jump
constexpr double kVolumeStep = 0.05;  // of the volume, in search of a pressure
constexpr double kSameVolume = 1e-6;
constexpr double kLeastStep = 1e-4;  // of a target, before a limit point is believed
constexpr int kMostIterations = 40;  // of a step: what takes longer is better halved
// A spring that holds the end of a piece of tube plane, over the membrane's stiffness: the ends are
// out of plane by its inverse.
constexpr double kPlaneStiffness = 1e3;
constexpr int kPbdSteps = 100;  // of 20 projections, at every load

std::vector<char> fixed_of(const Capsule& capsule, BalloonEnds ends) {
  std::vector<char> fixed = without_rigid_motion(capsule);
  if (ends == BalloonEnds::hemispheres) return fixed;
  // The poles hold nothing here: three vertices on the axes x and y do, against shift and turn.
  const int first = capsule.middle_ring * capsule.around;
  fixed[std::size_t(first)] = fixed[std::size_t(first + capsule.around / 2)] = kFixedY;
  fixed[std::size_t(first + capsule.around / 4)] = kFixedX;
  const auto hold = [&](int ring, int pole) {
    for (int k = 0; k < capsule.around; ++k)
      fixed[std::size_t(ring * capsule.around + k)] |= kFixedZ;
    fixed[std::size_t(pole)] |= kFixedZ;
  };
  hold(capsule.first_ring, capsule.low_pole);
  if (ends == BalloonEnds::fixed_length) hold(capsule.last_ring, capsule.high_pole);
  return fixed;
}

// Newton's method, from one state of rest to the next in steps that cannot jump.
class NewtonStates {
 public:
  NewtonStates(const FreeBalloon& balloon, const Capsule& capsule, double tolerance)
      : capsule_(capsule),
        membrane_(membrane_of(balloon, capsule)),
        plane_(capsule, kPlaneStiffness * balloon.material.wall_mm *
                            (moduli(balloon.material).c1 + moduli(balloon.material).c2)),
        terms_{&membrane_},
        fixed_(fixed_of(capsule, balloon.ends)) {
    if (balloon.ends == BalloonEnds::tube) terms_.push_back(&plane_);
    newton_.tolerance = tolerance;
    newton_.most_iterations = kMostIterations;
    state_.x = capsule.mesh.vertices;
    state_.volume = enclosed_volume(capsule.mesh);
    state_.converged = true;
  }

  FreeState advance(Hold hold, double target) {
    // Once a limit is met, what lies beyond is not tried.
    state_.converged = state_.converged &&
                       reach(hold == Hold::pressure ? Control::pressure : Control::volume, target);
    return state_;
  }

 private:
  // @return false if there is no state of rest on the way; the last one is kept
  bool reach(Control control, double target) {
    return control == Control::pressure ? reach_pressure(target) : walk(target);
  }

  // At once where the balloon is stiff. Where it is soft, near a limit point, by volumes: these
  // always have a state of rest, and a pressure that falls tells the limit.
  bool reach_pressure(double target) {
    if (target <= state_.pressure || try_state(Control::pressure, target)) return true;
    for (double growth = kVolumeStep; growth > kLeastStep;) {
      const FreeState before = state_;
      if (!walk((1.0 + growth) * before.volume)) return false;
      const double risen = state_.pressure - before.pressure;
      if (state_.pressure >= target || risen <= 0.0) {
        state_ = before;  // the state asked for, or the limit, lies between
        if (state_.pressure + 2.0 * std::abs(risen) >= target &&
            try_state(Control::pressure, target))
          return true;
        growth *= 0.5;
      } else if (target - state_.pressure < risen && try_state(Control::pressure, target)) {
        return true;
      }
    }
    return false;
  }

  // By volumes, each near enough to the last to be found from it.
  bool walk(double target) {
    while (state_.volume < (1.0 - kSameVolume) * target) {
      double next = std::min(target, kMostGrowth * state_.volume);
      while (!try_state(Control::volume, next)) {
        next = 0.5 * (state_.volume + next);
        if (next - state_.volume < kLeastStep * target) return false;
      }
    }
    return true;
  }

  bool try_state(Control control, double target) {
    std::vector<Vec3> x = state_.x;
    const NewtonResult result =
        minimize(terms_, fixed_, x, newton_,
                 {capsule_.mesh.triangles, control, target, 0.0, state_.pressure});
    if (!result.converged || result.volume > kMostGrowth * state_.volume ||
        !(result.volume > state_.volume))
      return false;
    state_ = {std::move(x), result.pressure, result.volume, result.residual, true};
    return true;
  }

  const Capsule& capsule_;
  MembraneTerm membrane_;
  PlaneTerm plane_;
  std::vector<const EnergyTerm*> terms_;
  std::vector<char> fixed_;
  NewtonOptions newton_;
  FreeState state_;
};

// Vertex block descent, the solver of simulate().
std::vector<FreeState> descent_states(const FreeBalloon& balloon, const Capsule& capsule,
                                      const InflateOptions& options, Hold hold,
                                      const std::vector<double>& targets) {
  SimulationModel model;
  model.balloon = capsule.mesh;
  model.balloon_rest = capsule.mesh.vertices;
  model.balloon_fixed.assign(capsule.mesh.vertices.size(), 0);
  model.guidewire = kAxis;
  model.measure_tangent = {0, 0, 1};
  SimulationOptions settings;
  settings.balloon = balloon.material;
  settings.backend = options.backend;
  std::vector<Load> loads;
  for (const double target : targets)
    loads.push_back({hold == Hold::pressure ? Load::Kind::pressure : Load::Kind::volume, target});
  std::vector<FreeState> states;
  for (Equilibrium& e : find_equilibria(model, settings, loads, options.tolerance_in_force()))
    states.push_back({std::move(e.x), e.pressure, e.volume, e.residual, e.converged});
  return states;
}

// The seed paper's position based dynamics under a given pressure: never at rest by its own
// measure, so never converged.
class PbdStates {
 public:
  PbdStates(const FreeBalloon& balloon, const Capsule& capsule)
      : capsule_(capsule),
        membrane_(membrane_of(balloon, capsule)),
        fixed_(without_rigid_motion(capsule)),
        solver_(capsule.mesh, moduli(balloon.material), balloon.material.wall_mm,
                density(balloon.material), std::vector<char>(capsule.mesh.vertices.size(), 0)) {
    // A wave crosses an edge in a step: its response depends on the step, and here it stays finite.
    const MooneyRivlin<double> m = moduli(balloon.material);
    const double speed = std::sqrt(6.0 * (m.c1 + m.c2) / density(balloon.material));
    step_.dt = distance(capsule.mesh.vertices[0], capsule.mesh.vertices[1]) / speed;
    step_.damping = 0.1;
  }

  FreeState advance(double pressure) {
    for (int i = 0; i < kPbdSteps; ++i) solver_.step(step_, pressure_forces(pressure));
    std::vector<Vec3> x = solver_.positions();
    const NewtonResult now = minimize({&membrane_}, fixed_, x, {.most_iterations = 0},
                                      {capsule_.mesh.triangles, Control::pressure, pressure});
    return {x, pressure, now.volume, now.residual, false};
  }

 private:
  [[nodiscard]] std::vector<Vec3> pressure_forces(double pressure) const {
    const std::vector<Vec3> x = solver_.positions();
    std::vector<Vec3> force(x.size());
    for (const auto& [a, b, c] : capsule_.mesh.triangles) {
      const Vec3& p = x[std::size_t(a)];
      const Vec3 third = (pressure / 6.0) * cross(x[std::size_t(b)] - p, x[std::size_t(c)] - p);
      for (const int v : {a, b, c}) force[std::size_t(v)] += third;
    }
    return force;
  }

  const Capsule& capsule_;
  MembraneTerm membrane_;
  std::vector<char> fixed_;
  PbdSolver solver_;
  PbdStep step_;
};

}  // namespace

MembraneTerm membrane_of(const FreeBalloon& balloon, const Capsule& capsule) {
  return {membrane_law(balloon.material), capsule.membrane, capsule.mesh.vertices,
          balloon.material.wall_mm, hoop_fibres(capsule.membrane, capsule.mesh.vertices, kAxis)};
}

Capsule mesh_of(const FreeBalloon& balloon, int around) {
  return balloon.ends == BalloonEnds::hemispheres
             ? make_capsule(balloon.radius_mm, balloon.length_mm, around)
             : make_tube_piece(balloon.radius_mm, around);
}

std::vector<FreeState> find_states(const FreeBalloon& balloon, const Capsule& capsule,
                                   const InflateOptions& options, Hold hold,
                                   const std::vector<double>& targets, const Progress& progress) {
  if (options.solver == InflateSolver::vbd)
    return descent_states(balloon, capsule, options, hold, targets);
  std::vector<FreeState> states;
  const auto add = [&](FreeState state) {
    states.push_back(std::move(state));
    progress.report(double(states.size()) / double(targets.size()), "inflate");
  };
  if (options.solver == InflateSolver::paper) {
    PbdStates paper(balloon, capsule);
    for (const double target : targets) add(paper.advance(target));
  } else {
    NewtonStates newton(balloon, capsule, options.tolerance_in_force());
    for (const double target : targets) add(newton.advance(hold, target));
  }
  return states;
}

}  // namespace angio::simulation::detail
