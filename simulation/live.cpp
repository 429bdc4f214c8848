#include "simulation/live.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/bodies/drawn_wire.hpp"
#include "simulation/run/frame_state.hpp"
#include "simulation/run/measure.hpp"
#include "simulation/run/wire_track.hpp"

namespace angio::simulation {
namespace {

using namespace detail;

constexpr double kPushMmPerS = 10.0;
constexpr double kNoLimit = 1e30;

/// What a hand cannot drive.
SimulationOptions drivable(SimulationOptions options) {
  options.gas_model = GasModel::enclosed;
  options.contact.model = ContactModel::barrier;
  options.validate();
  return options;
}

std::vector<Vec3> whole_wire(const SimulationModel& model) {
  std::vector<Vec3> wire = model.guidewire_before;
  wire.insert(wire.end(), model.guidewire.begin(), model.guidewire.end());
  wire.insert(wire.end(), model.guidewire_behind.begin(), model.guidewire_behind.end());
  return wire;
}

}  // namespace

struct LiveSimulation::Session {
  Session(SimulationModel given, SimulationOptions asked)
      : model(std::move(given)),
        options(drivable(std::move(asked))),
        shared_scene(std::make_shared<const Scene>(make_scene(model, options))),
        rules(make_rules(scene, options)),
        outside(outside_pressure(options)),
        track(whole_wire(model)),
        wire(model, options.guidewire) {
    if (max_penetration(scene, scene.start) > 0.0)
      throw InputError(
          "the balloon crosses the vessel wall before it is inflated (contact cannot part them). "
          "Try a smaller balloon.start_diameter_mm");
    solver = make_cpu_solver(scene, options);
    state = start_state(scene, outside);
    gas_start = outside * state.volume;
    const double peak = outside + units::pascal_from_atm(options.inflation.peak_pressure_atm);
    const double full = expected_volume(model, scene, state.volume);
    gas_full = peak * full;
    gas_in = gas_full * options.frame_s / options.inflation.inflate_s;
    kept_share = std::pow(gas_start / gas_full, options.frame_s / options.inflation.deflate_s);
    if (!model.guidewire.empty()) {
      least_mm = -track.abscissa_at(model.guidewire.front());
      most_mm = track.length_mm() - track.abscissa_at(model.guidewire.back());
    }
    complete();
  }

  /// The gas law of a step towards a pressure: a pump adds gas at a constant rate up to it, or lets
  /// gas out by a constant share down to it; there the valve holds the pressure.
  [[nodiscard]] GasLaw<double> law_towards(double pressure_atm) const {
    const double aim = outside + units::pascal_from_atm(std::clamp(pressure_atm, 0.0, 40.0));
    const double gas = state.pressure * state.volume;
    GasLaw<double> law;
    law.limit = law.top = kNoLimit;
    if (aim >= state.pressure) {
      law.lower = gas + gas_in;
      law.limit = gas + gas_in;
      law.top = aim;
    } else {
      law.lower = std::max(kept_share * gas, std::min(gas, gas_start));
      law.slope_pressure = aim;
      law.limit = gas;
    }
    return law;
  }

  /// Carries balloon and wire towards a place on the track.
  void push(double aim_mm) {
    const double most = kPushMmPerS * options.frame_s;
    const double step = std::clamp(std::clamp(aim_mm, least_mm, most_mm) - place_mm, -most, most);
    is_stuck = false;
    if (step == 0.0) return;
    std::vector<Vec3> x = state.x;
    const auto carry = [&](int first, int count) {
      for (int v = first; v < first + count; ++v)
        x[std::size_t(v)] = track.carried(x[std::size_t(v)], step);
    };
    carry(0, scene.bodies.balloon().count);
    if (scene.rod.count > 0) carry(scene.bodies.guidewire().first, scene.rod.count);
    is_stuck = max_penetration(scene, x) > 0.0;
    if (is_stuck) return;
    solver->put(x);
    place_mm += step;
  }

  void complete() {
    frame = {};
    frame.frame = number;
    frame.time_s = number * options.frame_s;
    add_state(model, shared_scene, std::make_shared<const State>(state), outside, frame);
    if (frame.guidewire.empty()) frame.guidewire = wire.follow(frame.balloon);
  }

  SimulationModel model;
  SimulationOptions options;
  std::shared_ptr<const Scene> shared_scene;
  const Scene& scene = *shared_scene;
  StepRules rules;
  double outside;  ///< [Pa]
  WireTrack track;
  DrawnWire wire;
  std::unique_ptr<StepSolver> solver;
  State state;
  SimulationFrame frame;
  int number = 0;
  double gas_start = 0.0, gas_full = 0.0;  ///< p V of the start, of the peak [Pa mm^3]
  double gas_in = 0.0, kept_share = 1.0;   ///< of a frame
  double place_mm = 0.0, least_mm = 0.0, most_mm = 0.0;
  bool is_stuck = false;
};

LiveSimulation::LiveSimulation(SimulationModel model, SimulationOptions options)
    : session_(std::make_unique<Session>(std::move(model), std::move(options))) {}
LiveSimulation::~LiveSimulation() = default;
LiveSimulation::LiveSimulation(LiveSimulation&&) noexcept = default;

const SimulationModel& LiveSimulation::model() const { return session_->model; }

const SimulationFrame& LiveSimulation::frame() const { return session_->frame; }

const SimulationFrame& LiveSimulation::step(const LiveAim& aim) {
  Session& s = *session_;
  ++s.number;
  s.push(aim.place_mm);
  s.state = s.solver->step(s.law_towards(aim.pressure_atm), s.rules);
  s.complete();
  return s.frame;
}

double LiveSimulation::place_mm() const { return session_->place_mm; }
double LiveSimulation::least_place_mm() const { return session_->least_mm; }
double LiveSimulation::most_place_mm() const { return session_->most_mm; }
bool LiveSimulation::is_stuck() const { return session_->is_stuck; }
std::string LiveSimulation::device() const { return session_->solver->device(); }

}  // namespace angio::simulation
