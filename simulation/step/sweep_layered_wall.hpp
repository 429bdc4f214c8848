#pragma once

#include "simulation/materials/solid_flow.hpp"
#include "simulation/step/sweep_sums.hpp"

/// The layered wall within a step: a column of the solid is moved at once (solid_column.hpp), with
/// the contact and the blood's pressure on its lumen vertex and the surrounding tissue on its last.
namespace angio::simulation::detail {

/// A vertex of a column in the step's numbering.
template <class Real>
ANGIO_HOST_DEVICE inline int column_vertex(const StepView<Real>& s, int column, int level) {
  return s.bodies.wall().first + level * s.layered.columns.stride + column;
}

/// The blood's pressure on a lumen vertex [uN]; it turns with the surface.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> blood_force(const StepView<Real>& s, int column) {
  Vec3T<Real> doubled_area;
  const Vec3T<Real> x = s.motion.x[column_vertex(s, column, 0)];
  for (int c = s.wall.mesh.corner_begin[column]; c < s.wall.mesh.corner_begin[column + 1]; ++c)
    doubled_area += cross(s.motion.x[s.wall.mesh.corners[c].next] - x,
                          s.motion.x[s.wall.mesh.corners[c].last] - x);
  return (s.layered.blood_pressure / Real(6)) * doubled_area;
}

/// What a column is about to do.
template <class Real>
struct ColumnMove {
  Vec3T<Real> move[kMostColumnLevels];
  double net = 0.0, load = 0.0;  ///< squared [uN^2]
};

/// Sums what the lanes have gathered of a column.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void gather_column(const Lanes& lanes, int levels,
                                            ColumnTerm<Real>& term) {
  for (int l = 0; l < levels; ++l) {
    term.gradient[l] = sum_over(lanes, term.gradient[l]);
    term.diagonal[l] = sum_over(lanes, term.diagonal[l]);
    if (l + 1 < levels) term.upper[l] = sum_over(lanes, term.upper[l]);
  }
}

template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline ColumnMove<Real> propose_column(const StepView<Real>& s, int v,
                                                         const Lanes& lanes) {
  const int column = v - s.bodies.wall().first, levels = s.layered.columns.levels;
  ColumnTerm<Real> term;
  add_solid_column(s.layered.solid, s.layered.columns, column, lanes, term);
  gather_column(lanes, levels, term);
  VertexForces<Real> lumen;
  if (s.contact.candidates.count > 0) add_contact(s, v, lanes, lumen);
  gather(s, lanes, lumen);
  const Real load = norm(term.gradient[0]) + lumen.magnitude;
  term.gradient[0] -= lumen.force + blood_force(s, column);
  term.diagonal[0] += lumen.hessian;
  const int last = column_vertex(s, column, levels - 1);
  term.gradient[levels - 1] +=
      s.wall.foundation[column] * (s.motion.x[last] - s.motion.start[last]);
  term.diagonal[levels - 1] += s.wall.foundation[column] * Mat3T<Real>::identity();
  ColumnMove<Real> out;
  for (int l = 0; l < levels; ++l) {
    const int u = column_vertex(s, column, l);
    const Real k = s.motion.mass[u] / (s.motion.dt * s.motion.dt);
    term.gradient[l] += k * (s.motion.x[u] - s.motion.x_inertial[u]);
    term.diagonal[l] += k * Mat3T<Real>::identity();
    out.net += double(norm_squared(term.gradient[l]));
  }
  out.load = double(load) * double(load);
  solve_column(term, levels, out.move);
  return out;
}

/// The share of a column's move that leaves every layer most of its height: no wedge may turn
/// inside out within a move.
template <class Real>
ANGIO_HOST_DEVICE inline Real upright_share(const StepView<Real>& s, int column,
                                            const Vec3T<Real>* move) {
  constexpr Real kMost = Real(0.3);
  Real share = 1;
  for (int l = 0; l + 1 < s.layered.columns.levels; ++l) {
    const Real height =
        norm(s.motion.x[column_vertex(s, column, l + 1)] - s.motion.x[column_vertex(s, column, l)]);
    const Real change = norm(move[l + 1] - move[l]);
    if (change * share > kMost * height) share = kMost * height / change;
  }
  return share;
}

/// Moves a column. @return the part that its bounds left of the move
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Real take_column(const StepView<Real>& s, int v, const Lanes& lanes,
                                          const ColumnMove<Real>& proposed, Real travel) {
  const int column = v - s.bodies.wall().first;
  const Real upright = upright_share(s, column, proposed.move);
  const Real bounded = allowed_share(s, v, upright * proposed.move[0], travel);
  lanes.sync();
  if (lanes.rank() > 0) return bounded;
  const Real share = bounded * upright;
  move_wall_vertex(s, v, share * proposed.move[0]);
  for (int l = 1; l < s.layered.columns.levels; ++l)
    s.motion.x[column_vertex(s, column, l)] += share * proposed.move[l];
  return bounded;
}

/// Lets a wedge's points flow at the positions reached: F_e <- F_e G^-1 is g_a <- G^-T g_a.
template <class Real>
ANGIO_HOST_DEVICE inline void flow_wedge(const StepView<Real>& s, int w) {
  const SolidWedge<Real> wedge = s.layered.solid.wedge(w);
  if (!(wedge.law.yield > Real(0))) return;
  Vec3T<Real> x[6];
  s.layered.solid.gather(w, x);
  for (int q = 0; q < kWedgePoints; ++q) {
    SolidPoint<Real>& point = s.layered.points[kWedgePoints * w + q];
    const FlowStep<Real> step =
        flow_solid(wedge.law, wedge.fiber, solid::deformation(point, x), s.motion.dt);
    if (!(step.strain > Real(0))) continue;
    const Mat3T<Real> back = transpose(inverse(step.growth));
    for (int a = 0; a < 6; ++a) point.g[a] = back * point.g[a];
    s.layered.plastic_strain[kWedgePoints * w + q] += step.strain;
  }
}

/// The same of a layered wall's columns.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void move_wall_columns(Team& team, const StepView<Real>& s, int first,
                                                int count, double (&total)[3]) {
  team.template quick_sum<Team::kVertexLanes, 3>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const ColumnMove<Real> column = propose_column(s, first + i, lanes);
        part[0] += column.net;
        part[1] += column.load;
        const Real share =
            take_column(s, first + i, lanes, column, s.contact.near.max_move[first + i]);
        part[2] += share < Real(1) ? Real(1) : Real(0);
      },
      total);
}

}  // namespace angio::simulation::detail
