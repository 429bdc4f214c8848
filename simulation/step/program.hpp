#pragma once

#include "simulation/step/sweep.hpp"

/// The step as a program for a team of threads (team.hpp), the same source for every backend.
///
/// An implicit Euler step by vertex block descent: sweeps over the vertices, colour by colour, each
/// vertex taking a Newton step in its own 3 x 3 block.
///
/// Source: Chen, Liu, Yang, Yuksel, "Vertex Block Descent", ACM TOG 43 (2024), Eqs. 4-9; here with
/// over-relaxation in place of the Chebyshev acceleration, and with the enclosed gas, which couples
/// all vertices through one number, met exactly once a colour: the volume is linear in the vertices
/// of a colour, V(p) = V + sum g . H^-1 (f + (p - p_0) g), and the gas law is solved against it.
namespace angio::simulation::detail {

/// A step is begun with this share of the last one's motion: balloon and wall then go on together,
/// which sweeps alone, moving one against the other, do slowly. Below 1, so that errors die out.
inline constexpr double kForesight = 0.9;
/// A vertex that has met its bound waits for so many sweeps for the next search. Layers of folds
/// are near each other everywhere: searches are dear there, and the less they move the fewer pairs.
inline constexpr int kPatience = 2, kFoldsPatience = 4;
inline constexpr int kLeastSweeps = 3;   // for what rests
inline constexpr int kSweepsToTell = 4;  // for the lag to be known

/// A third of the triangles around each vertex of the surfaces.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void measure_areas(Team& team, const StepView<Real>& s) {
  const Vec3T<Real>* x = s.motion.x;
  team.template for_each<1>(s.bodies.surface_count(), [&](int v, const auto&) {
    const MeshView& mesh = mesh_around(s, v);
    const int* begin = mesh.corner_begin + (v - mesh.first);
    Real area = 0;
    for (int c = begin[0]; c < begin[1]; ++c)
      area += norm(cross(x[mesh.corners[c].next] - x[v], x[mesh.corners[c].last] - x[v])) / Real(6);
    s.motion.area[v] = area;
  });
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void begin_step(Team& team, const StepView<Real>& s,
                                         const StepRules& rules, StepStatus& status) {
  if constexpr (Team::kSolids) begin_pbd(s, status);
  team.template for_each<1>(s.motion.count, [&](int v, const auto&) {
    s.motion.x_before[v] = s.motion.x[v];
    s.motion.x_inertial[v] =
        rules.still ? s.motion.x[v] : s.motion.x[v] + s.motion.dt * s.motion.velocity[v];
  });
  measure_areas(team, s);
  team.barrier();
  if (has_pairs<Team>(s))
    team.template for_each<1>(s.bodies.contact_count(), [&](int i, const auto&) {
      const int v = s.bodies.contact_vertex(i);
      s.contact.near.max_move[v] = useful_move(s, v);
    });
  double total[1];
  team.template quick_sum<1, 1>(
      s.bodies.balloon().count,
      [&](int v, const auto&, auto* part) {
        const Real load = Real(rules.least_load) * s.motion.area[v];
        part[0] += load * load;
      },
      total);
  status.load_floor = total[0];
  for (double& moved : status.moved) moved = 0.0;
  status.leap = {};
  status.report = {};
  status.blocked = status.wall_rests = false;
}

/// Goes on with the last step's motion.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void foresee(Team& team, const StepView<Real>& s, const StepRules& rules,
                                      StepStatus& status) {
  if (!rules.still)
    move_all(team, s, [&](int v) {
      return Real(kForesight) * (s.motion.x_inertial[v] - s.motion.x_before[v]);
    });
  if constexpr (Team::kSolids) {
    if (!rules.still && s.layered.columns.levels > 0)
      take_back_if_strained(team, s, s.motion.x_before);
  }
  if (Team::kSurroundings && !rules.still && s.guidewire.shape.count > 0) {
    team.template for_each<1>(s.guidewire.shape.count, [&](int i, const auto&) {
      const int v = s.guidewire.first + i;
      s.guidewire.rows[i].force =
          kForesight * in_double(s.motion.x_inertial[v] - s.motion.x_before[v]);
    });
    team.barrier();
    take_rod(team, s);
  }
  if (!rules.still && s.slide.count > 0) {
    const int v = s.slide.vertices[0];
    slide_by(team, s,
             Real(kForesight) * dot(s.slide.along, s.motion.x_inertial[v] - s.motion.x_before[v]));
  }
  measure_gas(team, s, status);
}

/// To be called before a sweep that leaps are to take into account.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void mark_positions(Team& team, const StepView<Real>& s) {
  team.template for_each<1>(s.motion.count,
                            [&](int v, const auto&) { s.motion.x_swept[v] = s.motion.x[v]; });
}

/// After a sweep: leaps to where the sweeps lead, if they go on in one direction (leap.hpp).
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void leap(Team& team, const StepView<Real>& s, StepStatus& status) {
  double total[3];
  team.template quick_sum<1, 3>(
      s.motion.count,
      [&](int v, const auto&, auto* part) {
        const Vec3T<Real> before = s.motion.swept_by[v], now = s.motion.x[v] - s.motion.x_swept[v];
        part[0] += dot(before, now);
        part[1] += norm_squared(before);
        part[2] += norm_squared(now);
        s.motion.swept_by[v] = now;
        s.motion.x_swept[v] = s.motion.x[v];
      },
      total);
  const double length = leap_length(status.leap, total);
  if (!(length > 0.0)) return;
  const bool held = move_all(team, s, [&](int v) { return Real(length) * s.motion.swept_by[v]; });
  if constexpr (Team::kSolids) {
    if (s.layered.columns.levels > 0) take_back_if_strained(team, s, s.motion.x_swept);
  }
  const bool slides = s.slide.count > 0;
  const bool is_neck_held =
      slides &&
      slide_by(team, s, Real(length) * dot(s.slide.along, s.motion.swept_by[s.slide.vertices[0]]));
  status.blocked = status.blocked || held || is_neck_held;
  status.leap = {};
  for (double& moved : status.moved) moved = 0.0;
  mark_positions(team, s);
  measure_gas(team, s, status);
}

/// The distance still to go, from how the last sweeps' motions m shrink: m q / (1 - q) [mm].
ANGIO_HOST_DEVICE inline double estimated_lag(const double (&moved)[4]) {
  if (!(moved[3] > 0.0)) return moved[0];  // too few sweeps to tell
  double q = std::cbrt(moved[0] / moved[3]);
  q = q < 0.98 ? q : 0.98;
  return moved[0] * q / (1.0 - q);
}

/// How much of what the balloon's vertices carried of contact in the last sweep has changed since,
/// where its moves have led: root of the sum of squares, as the load [uN]. Renews the pairs.
///
/// A pair in a crease is stiff enough for the moves of one sweep to press it many times as hard
/// as the sweep has found it: the residual, of before the moves, does not know.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline double contact_jump(Team& team, const StepView<Real>& s) {
  refresh(team, s);
  double total[1] = {0.0};
  if (has_pairs<Team>(s))
    team.template quick_sum<Team::kBalloonLanes, 1>(
        last_of_balloon(s),
        [&](int v, const auto& lanes, auto* part) {
          VertexForces<Real> f;
          add_contact(s, v, lanes, f);
          const Real jump = lanes.sum(f.contact) - s.balloon.moves[v].contact;
          part[0] += jump * jump;
        },
        total);
  return std::sqrt(total[0]);
}

/// Sweeps until the step has converged or has had its sweeps, and renews the pairs. @return false
/// if it must halt for new candidates; to be called again when they are there
template <class Real, class Team>
ANGIO_HOST_DEVICE inline bool run_sweeps(Team& team, const StepView<Real>& s,
                                         const StepRules& rules, StepStatus& status) {
  StepReport& report = status.report;
  // A balloon alone has no mode that is slow, unless its length is free.
  const bool leaps = ((Team::kSurroundings && s.bodies.wall().count > 0) || s.slide.count > 0) &&
                     !s.pbd.fills_balloon();
  bool is_refreshed = false;
  if (leaps) mark_positions(team, s);
  const int patience = s.balloon.has_folds ? kFoldsPatience : kPatience;
  // A slack membrane that comes to lie on a shaft in a bend is far from balance at the start: what
  // others leave to the next frame it would leave to many.
  const bool settles = !status.has_stepped && s.guidewire.shape.count > 0;
  const double most_residual = settles ? kLaterResidual : kBalanceMargin * kOffBalance;
  const auto goes_on = [&] {
    return report.sweeps < rules.most_sweeps ||
           (report.sweeps < rules.last_sweeps && report.residual > most_residual);
  };
  while (goes_on()) {
    if (status.blocked && status.since_search >= patience && !search_pairs(team, s, status))
      return false;
    status.wall_rests = status.wall_rests && report.pair_count == 0;
    const SweepSums sums = sweep(team, s, !status.wall_rests, status);
    // A solid that is in balance stays there until a pair can reach it.
    status.wall_rests =
        status.wall_rests || (s.layered.columns.levels > 0 && report.pair_count == 0 &&
                              sums.wall_net <= rules.rest * rules.rest * sums.wall_load);
    ++report.sweeps;
    ++status.leap.sweeps;
    ++status.since_search;
    status.blocked = sums.blocked();
    report.residual = std::sqrt(sums.net / (sums.load + status.load_floor));
    for (int i = 3; i > 0; --i) status.moved[i] = status.moved[i - 1];
    status.moved[0] = std::sqrt(sums.moved / s.bodies.balloon().count);
    const double withheld = std::sqrt(sums.withheld / s.bodies.balloon().count);
    report.lag = (estimated_lag(status.moved) + withheld) / rules.radius;
    const bool is_late = report.sweeps >= rules.later_sweeps;
    const bool is_slack =
        report.sweeps >= rules.slack_sweeps && sums.slack > kSlackShare * s.bodies.balloon().count;
    const bool near_slack = is_slack && report.residual < kLaterResidual &&
                            status.moved[0] + withheld < rules.tolerance * rules.radius;
    const bool near = status.leap.sweeps >= kSweepsToTell && report.sweeps >= rules.least_sweeps &&
                      report.lag < (is_late ? kLaterLag : 1.0) * rules.tolerance &&
                      report.residual < (is_late ? kLaterResidual : rules.residual);
    const bool rests = report.residual < rules.rest && withheld < rules.tolerance * rules.radius;
    const bool would_end = report.sweeps >= kLeastSweeps && (near || near_slack || rests),
               has_spent = report.sweeps >= rules.most_sweeps && rules.last_sweeps > 0;
    if (would_end || has_spent) {
      const double jump =
          contact_jump(team, s) / std::sqrt(sums.load - sums.wall_load + status.load_floor);
      if (has_spent && jump > report.residual) report.residual = jump;
      is_refreshed = (would_end && jump <= kLaterResidual) || !goes_on();
      if (is_refreshed) break;
    }
    if (leaps) leap(team, s, status);
  }
  if (!is_refreshed) refresh(team, s);
  return true;
}

/// Measures the contact, where pairs are renewed, lets the wall flow, and takes the velocities.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void end_step(Team& team, const StepView<Real>& s,
                                       const PlasticFlow<Real>& plasticity, StepStatus& status) {
  status.volume = enclosed_volume(team, s);
  if (!(status.law.volume > 0.0)) status.pressure = pressure_at(status.law, status.volume);
  team.template for_each<1>(s.motion.count, [&](int v, const auto&) {
    s.motion.velocity[v] = (s.motion.x[v] - s.motion.x_before[v]) / s.motion.dt;
  });
  if (!Team::kSurroundings || s.bodies.wall().count == 0) return;
  double total[3];
  team.template quick_sum<1, 3>(
      s.bodies.surface_count(),
      [&](int v, const auto& lanes, auto* part) {
        VertexForces<Real> f;
        if (has_pairs<Team>(s)) add_contact(s, v, lanes, f);
        if (s.bodies.of(v) == Body::wall) {
          // Pairs across an edge pull aside against each other: what is left of them.
          s.wall.contact_pressure[v - s.bodies.wall().first] =
              norm(f.force - f.friction - f.adhesion - f.own) / s.motion.area[v];
          return;
        }
        part[0] += f.touching_wall ? Real(1) : Real(0);
        if (v >= last_of_balloon(s)) return;
        part[1] += s.balloon.moves[v].friction;
        part[2] += s.balloon.moves[v].adhesion;
      },
      total);
  if (!s.pbd.parts_surfaces()) {  // else what the last sweep has projected
    status.report.contact_count = int(total[0]);
    status.report.friction_delta = total[1];
    status.report.viscous_delta = total[2];
  }
  if (s.contact.wet)
    team.template for_each<1>(s.bodies.surface_count(),
                              [&](int v, const auto&) { flow_film(s, v); });
  team.template for_each<Team::kSlabLanes>(
      s.slabs.count, [&](int c, const auto& lanes) { flow_slab(s, plasticity, c, lanes); });
  if constexpr (Team::kSolids)
    team.template for_each<1>(s.layered.wedge_count, [&](int w, const auto&) { flow_wedge(s, w); });
  team.barrier();
}

/// Takes a step, or goes on with one that has halted. @return false if it halts for new candidates
template <class Real, class Team>
ANGIO_HOST_DEVICE inline bool run_step(Team& team, const StepView<Real>& s, const StepRules& rules,
                                       const PlasticFlow<Real>& plasticity, StepStatus& status) {
  const double begin = team.now();
  StepTimes& times = status.report.times;
  if (status.stage == StepStage::begin) {
    begin_step(team, s, rules, status);
    status.stage = StepStage::foresight;
  }
  const bool begun = status.stage == StepStage::foresight;
  if (begun) {
    if (!search_pairs(team, s, status)) return false;
    foresee(team, s, rules, status);
    status.stage = StepStage::sweeps;
  }
  if (begun) times.rest += team.now() - begin - times.search;
  if (!run_sweeps(team, s, rules, status)) return false;
  const double swept = team.now();
  end_step(team, s, plasticity, status);
  times.rest += team.now() - swept;
  status.stage = StepStage::begin;
  status.has_stepped = true;
  return true;
}

}  // namespace angio::simulation::detail
