#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "core/units.hpp"
#include "simulation/detail/step.hpp"

namespace angio::simulation::detail {
namespace {

constexpr double kRelaxation = 1.6;          // fastest on an inflating capsule
constexpr double kResidualTolerance = 0.02;  // sweeps go on above it,
constexpr double kResidualAtRest = 1e-3;     // and end early below this one
constexpr int kLeastSweeps = 4;
constexpr int kMaxSweepFactor = 6;  // up to this many times the number asked for
// Loops shorter than this run on one thread: they take less than a millisecond, and on a busy
// computer waking and awaiting a second thread for each of a step's hundreds of loops takes longer.
constexpr std::ptrdiff_t kLeastParallel = 16384;
// A step is begun with this share of the last one's motion: balloon and wall then go on together,
// which sweeps alone, moving one against the other, do slowly. Below 1, so that errors die out.
constexpr double kForesight = 0.9;
constexpr double kStickSpeed = 0.02;  // slip speed below which contact sticks [mm/s]

// parallel_for over `count` iterations of about equal cost, a microsecond each.
template <class Body>
void for_each(std::ptrdiff_t count, const Body& body) {
  if (count >= kLeastParallel)
    parallel_for(count, body);
  else
    for (std::ptrdiff_t i = 0; i < count; ++i) body(i);
}

}  // namespace

double balloon_volume(const Scene& scene, const std::vector<Vec3>& x) {
  double volume = 0.0;
  const Vec3 origin = x[0];
  for (const Triangle& t : scene.balloon_triangles)
    volume += dot(x[std::size_t(t[0])] - origin,
                  cross(x[std::size_t(t[1])] - origin, x[std::size_t(t[2])] - origin));
  return volume / 6.0;
}

State start_state(const Scene& scene, double pressure) {
  State state;
  state.x = scene.start;
  state.velocity.assign(scene.start.size(), {});
  state.rotation.assign(std::size_t(scene.clusters.count()), Mat3::identity());
  state.plastic = state.rotation;
  state.pressure = pressure;
  state.volume = balloon_volume(scene, state.x);
  return state;
}

StepSolver::StepSolver(const Scene& scene, const SimulationOptions& options)
    : scene_(scene),
      options_(options),
      plasticity_{options.wall.yield_strain, options.wall.creep_per_s,
                  options.wall.max_plastic_strain} {
  const std::size_t wall_count = std::size_t(scene.wall_count);
  goal_.resize(wall_count);
  goal_stiffness_.assign(wall_count, 0.0);
  contact_pressure_.assign(wall_count, 0.0);
  cluster_map_.resize(std::size_t(scene.clusters.count()));
  cluster_centre_.resize(cluster_map_.size());
  moves_.resize(scene.start.size());
  blocked_.assign(scene.start.size(), 0);
  area_.resize(scene.start.size());
  for (std::size_t e = 0; e < scene.clusters.vertex.size(); ++e)
    goal_stiffness_[std::size_t(scene.clusters.vertex[e])] += scene.clusters.stiffness[e];

  const double peak = units::pascal_from_atm(options.inflation.peak_pressure_atm);
  view_.balloon_count = scene.balloon_count;
  view_.outside_pressure = outside_pressure(options);
  view_.contact_distance = options.contact_distance_mm;
  view_.contact_stiffness = barrier_stiffness(peak, options.contact_distance_mm);
  view_.relaxation = kRelaxation;
  view_.skin = scene.skin;
  view_.folds = scene.folds;
  view_.relaxed = scene.relaxed;
  view_.start = scene.start.data();
  view_.mass = scene.mass.data();
  view_.corner_begin = scene.corner_begin.data();
  view_.corners = scene.corners.data();
  view_.cluster_begin = scene.clusters.begin.data();
  view_.cluster_vertex = scene.clusters.vertex.data();
  view_.cluster_stiffness = scene.clusters.stiffness.data();
  view_.cluster_offset = scene.clusters.offset.data();
  view_.entry_begin = scene.clusters.entry_begin.data();
  view_.entry = scene.clusters.entry.data();
  view_.entry_cluster = scene.clusters.entry_cluster.data();
  view_.neighbor_begin = scene.neighbor_begin.data();
  view_.neighbors = scene.neighbors.data();
  view_.foundation = scene.foundation.data();
  view_.goal = goal_.data();
  view_.goal_stiffness = goal_stiffness_.data();
  view_.cluster_map = cluster_map_.data();
  view_.cluster_centre = cluster_centre_.data();
}

StepReport StepSolver::step(const GasLaw<double>& law, double dt, State& state) {
  StepReport report;
  begin_step(dt, state);
  detect(state);
  report.detections = 1;
  for (int v = 0; v < scene_.vertex_count(); ++v)
    if (!scene_.fixed[std::size_t(v)])
      move_vertex(v, kForesight * (x_inertial_[std::size_t(v)] - x_before_[std::size_t(v)]));
  int since_detection = 0;
  const int most = kMaxSweepFactor * options_.sweeps;
  for (report.sweeps = 1; report.sweeps <= most; ++report.sweeps) {
    std::fill(blocked_.begin(), blocked_.end(), char(0));
    for_each(std::ptrdiff_t(contacts_.pairs.size()),
             [&](std::ptrdiff_t i) { refresh_pair(view_, int(i)); });
    fit_wall();
    sweep_balloon(law, state);
    sweep_wall(state);
    report.residual = residual();
    ++since_detection;
    const bool blocked = any_blocked();
    const double enough = report.sweeps >= options_.sweeps ? kResidualTolerance : kResidualAtRest;
    if (report.sweeps >= kLeastSweeps && report.residual < enough && !blocked) break;
    if (blocked && since_detection >= 2 && report.sweeps < most) {
      detect(state);
      ++report.detections;
      since_detection = 0;
    }
  }
  report.sweeps = std::min(report.sweeps, most);
  state.volume = balloon_volume(scene_, state.x);
  state.pressure = pressure_at(law, state.volume);
  for (int v = 0; v < scene_.balloon_count; ++v)
    report.friction_delta += norm(moves_[std::size_t(v)].friction);
  measure_contact(state);
  flow_wall(dt, state);
  last_motion_ = 0.0;
  for (std::size_t v = 0; v < state.x.size(); ++v) {
    last_motion_ = std::max(last_motion_, distance(state.x[v], x_before_[v]));
    state.velocity[v] = (state.x[v] - x_before_[v]) / dt;
  }
  return report;
}

void StepSolver::begin_step(double dt, State& state) {
  x_before_ = state.x;
  x_inertial_ = state.x;
  for (std::size_t v = 0; v < state.x.size(); ++v) x_inertial_[v] += dt * state.velocity[v];
  std::fill(area_.begin(), area_.end(), 0.0);
  for (const auto* triangles : {&scene_.balloon_triangles, &scene_.wall_triangles})
    for (const Triangle& t : *triangles) {
      const Vec3& a = state.x[std::size_t(t[0])];
      const double third =
          norm(cross(state.x[std::size_t(t[1])] - a, state.x[std::size_t(t[2])] - a)) / 6.0;
      for (const int v : t) area_[std::size_t(v)] += third;
    }
  view_.dt = dt;
  view_.friction = {options_.friction_static, options_.friction_kinetic, kStickSpeed * dt};
  view_.x = state.x.data();
  view_.x_before = x_before_.data();
  view_.x_inertial = x_inertial_.data();
  view_.cluster_rotation = state.rotation.data();
  view_.cluster_plastic = state.plastic.data();
  // A slack balloon's forces are measured against a tenth of the peak pressure, not against
  // nothing.
  load_floor_ = 0.0;
  const double least = 0.1 * units::pascal_from_atm(options_.inflation.peak_pressure_atm);
  for (int v = 0; v < scene_.balloon_count; ++v) {
    const double f = least * area_[std::size_t(v)];
    load_floor_ += f * f;
  }
}

void StepSolver::detect(const State& state) {
  x_detected_ = state.x;
  view_.x_detected = x_detected_.data();
  const double d = options_.contact_distance_mm;
  const double travel = std::clamp(1.5 * last_motion_, 0.5 * d, 2.0 * d);
  contacts_ = find_contacts(scene_, state.x, area_, d + 2.0 * travel, travel);
  // Without a wall nothing bounds a motion; a vertex still may not jump over the balloon.
  if (scene_.wall_count == 0) contacts_.travel = 1e9;
  view_.travel = contacts_.travel;
  pair_weights_.assign(contacts_.pairs.size(), 0.0);
  view_.pairs = contacts_.pairs.data();
  view_.pair_weights = pair_weights_.data();
  view_.ref_begin = contacts_.ref_begin.data();
  view_.refs = contacts_.refs.data();
  view_.bound_begin = contacts_.bound_begin.data();
  view_.bounds = contacts_.bounds.data();
}

void StepSolver::fit_wall() {
  for_each(scene_.clusters.count(), [&](std::ptrdiff_t c) { fit_cluster(view_, int(c)); });
  for_each(scene_.wall_count, [&](std::ptrdiff_t i) { set_goal(view_, int(i)); });
}

void StepSolver::move_vertex(int v, const Vec3& move) {
  const double share = allowed_share(view_, v, move);
  if (share < 1.0) blocked_[std::size_t(v)] = 1;
  view_.x[v] += share * move;
}

void StepSolver::sweep_balloon(const GasLaw<double>& law, State& state) {
  const Coloring& colors = scene_.balloon_colors;
  state.volume = balloon_volume(scene_, state.x);
  state.pressure = pressure_at(law, state.volume);
  for (std::size_t color = 0; color + 1 < colors.begin.size(); ++color) {
    const int* group = colors.vertices.data() + colors.begin[color];
    const std::ptrdiff_t count = colors.begin[color + 1] - colors.begin[color];
    const double pressure = state.pressure;
    for_each(count, [&](std::ptrdiff_t i) {
      const int v = group[i];
      Move& move = moves_[std::size_t(v)];
      const VertexForces f = balloon_forces(view_, v, move.by_volume);
      const Mat3 inverse = inverse_block(f.hessian);
      const Vec3 load = (pressure - view_.outside_pressure) * move.by_volume;
      const double relax = f.touching ? 1.0 : view_.relaxation;
      move.by_force = relax * (inverse * (f.force + load));
      move.by_pressure = relax * (inverse * move.by_volume);
      move.friction = inverse * f.friction;
      move.taut = f.taut;
      move.net = norm_squared(f.force + load);
      move.load = norm_squared(load) + f.contact * f.contact;
    });
    double grown = 0.0, compliance = 0.0;
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const Move& move = moves_[std::size_t(group[i])];
      grown += dot(move.by_volume, move.by_force);
      compliance += dot(move.by_volume, move.by_pressure);
    }
    const double least = 1e-3 * state.volume;
    const double change =
        meet(law, pressure, std::max(state.volume + grown, least), compliance) - pressure;
    for_each(count, [&](std::ptrdiff_t i) {
      const int v = group[i];
      const Move& move = moves_[std::size_t(v)];
      const Vec3 whole = move.by_force + change * move.by_pressure;
      const double gauge = pressure + change - view_.outside_pressure;
      move_vertex(v, !move.taut ? balloon_line_search(view_, v, gauge, whole) * whole : whole);
    });
    state.volume = balloon_volume(scene_, state.x);
    state.pressure = pressure_at(law, state.volume);
  }
}

void StepSolver::sweep_wall(State& state) {
  const Coloring& colors = scene_.wall_colors;
  for (std::size_t color = 0; color + 1 < colors.begin.size(); ++color) {
    const int* group = colors.vertices.data() + colors.begin[color];
    for_each(colors.begin[color + 1] - colors.begin[color], [&](std::ptrdiff_t i) {
      const int v = group[i];
      const VertexForces f = wall_forces(view_, v);
      Move& move = moves_[std::size_t(v)];
      move.net = norm_squared(f.force);
      move.load = f.magnitude * f.magnitude;
      if (move.net > 0.0) move_vertex(v, inverse_block(f.hessian) * f.force);
    });
  }
  (void)state;
}

double StepSolver::residual() const {
  double net = 0.0, load = load_floor_;
  for (const Move& move : moves_) {
    net += move.net;
    load += move.load;
  }
  return std::sqrt(net / load);
}

bool StepSolver::any_blocked() const {
  return std::any_of(blocked_.begin(), blocked_.end(), [](char b) { return b != 0; });
}

void StepSolver::flow_wall(double dt, State& state) {
  fit_wall();
  for_each(scene_.clusters.count(), [&](std::ptrdiff_t i) {
    const auto c = std::size_t(i);
    state.plastic[c] = flow(plasticity_, cluster_stretch(view_, int(c)), state.plastic[c], dt);
  });
}

void StepSolver::measure_contact(State& state) {
  for_each(std::ptrdiff_t(contacts_.pairs.size()),
           [&](std::ptrdiff_t i) { refresh_pair(view_, int(i)); });
  contact_count_ = 0;
  for (int v = 0; v < scene_.vertex_count(); ++v) {
    VertexForces f;
    add_contact(view_, v, f);
    if (v < scene_.balloon_count)
      contact_count_ += f.touching ? 1 : 0;
    else
      contact_pressure_[std::size_t(v - scene_.balloon_count)] = f.contact / area_[std::size_t(v)];
  }
  (void)state;
}

}  // namespace angio::simulation::detail
