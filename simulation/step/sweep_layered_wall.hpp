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

/// What holds a level of a column beside the solid: inertia, and the surrounding tissue the last
/// [uN/mm].
template <class Real>
ANGIO_HOST_DEVICE inline Real hold_of_level(const StepView<Real>& s, int column, int l) {
  const Real inertia = s.motion.mass[column_vertex(s, column, l)] / (s.motion.dt * s.motion.dt);
  return l + 1 < s.layered.columns.levels ? inertia : inertia + s.wall.foundation[column];
}

/// The most that has been renewed of a column's wedges.
template <class Real>
ANGIO_HOST_DEVICE inline Renewed renewed_around(const SolidColumns& columns,
                                                const ColumnRows<Real>& rows, int column) {
  Renewed most = Renewed::nothing;
  for (int n = columns.wedge_begin[column]; n < columns.wedge_begin[column + 1]; ++n) {
    const Renewed renewed = rows.renewed[columns.wedges[n].wedge];
    most = renewed > most ? renewed : most;
  }
  return most;
}

/// Takes the lines of the wedges that have been strained, and renews the columns around them.
/// @param sweep  of the step
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void renew_columns(Team& team, const StepView<Real>& s, int sweep) {
  const SlopeAge most = oldest_slopes(sweep);
  const SolidView<Real>& solid = s.layered.solid;
  const SolidColumns& columns = s.layered.columns;
  const ColumnRows<Real>& rows = s.layered.rows;
  team.template for_each<1>(s.layered.wedge_count,
                            [&](int w, const auto&) { renew_wedge(solid, rows, most, w); });
  team.barrier();
  team.template for_each<1>(s.layered.patch_count,
                            [&](int p, const auto&) { renew_patch(solid, rows, p); });
  team.barrier();
  const int moving = s.wall.mesh.color_begin[s.wall.mesh.colors] - s.bodies.wall().first;
  team.template for_each<Team::kVertexLanes>(moving, [&](int column, const auto& lanes) {
    const Renewed renewed = renewed_around(columns, rows, column);
    if (renewed == Renewed::nothing) return;
    gather_constants(columns, rows, column, lanes);
    for (int e = columns.patch_begin[column] + lanes.rank(); e < columns.patch_begin[column + 1];
         e += lanes.size())
      gather_patch(solid, columns, rows, column, e);
    if (renewed == Renewed::force) return;
    gather_links(columns, rows, column, lanes);
    lanes.sync();
    for (int l = lanes.rank(); l < columns.levels; l += lanes.size())
      gather_level(solid, columns, rows, column, l);
    lanes.sync();
    if (lanes.rank() > 0) return;
    eliminate(columns, rows, column, [&](int l) { return hold_of_level(s, column, l); });
    rows.steepness[column] = column_steepness(columns, rows, column);
  });
  team.barrier();
}

/// A column without sound layers goes with the mean displacement of its neighbours, level by level:
/// it neither holds the wall nor bears a load.
template <class Real>
ANGIO_HOST_DEVICE inline ColumnMove<Real> lead_column(const StepView<Real>& s, int v) {
  const MeshView& mesh = s.wall.mesh;
  const int first = mesh.corner_begin[v - mesh.first], end = mesh.corner_begin[v - mesh.first + 1];
  const Real share = Real(0.5) / Real(end - first);
  ColumnMove<Real> out;
  for (int l = 0; l < s.layered.columns.levels; ++l) {
    const int up = l * s.layered.columns.stride;
    const auto displacement = [&](int u) { return s.motion.x[u + up] - s.motion.start[u + up]; };
    Vec3T<Real> sum;
    for (int c = first; c < end; ++c)
      sum += displacement(mesh.corners[c].next) + displacement(mesh.corners[c].last);
    out.move[l] = share * sum - displacement(v);
  }
  return out;
}

template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline ColumnMove<Real> propose_column(const StepView<Real>& s, int v,
                                                         const Lanes& lanes) {
  const int column = v - s.bodies.wall().first, levels = s.layered.columns.levels;
  if (s.layered.led[column]) return lead_column(s, v);
  Vec3T<Real> gradient[kMostColumnLevels];
  add_column_gradient(s.layered.solid, s.layered.columns, s.layered.rows, column, lanes, gradient);
  for (int l = 0; l < levels; ++l) gradient[l] = sum_over(lanes, gradient[l]);
  VertexForces<Real> lumen;
  if (s.contact.candidates.count > 0) add_contact(s, v, lanes, lumen);
  gather(s, lanes, lumen);
  const Real load = norm(gradient[0]) + lumen.magnitude;
  gradient[0] -= lumen.force + blood_force(s, column);
  const int last = column_vertex(s, column, levels - 1);
  gradient[levels - 1] += s.wall.foundation[column] * (s.motion.x[last] - s.motion.start[last]);
  ColumnMove<Real> out;
  for (int l = 0; l < levels; ++l) {
    const int u = column_vertex(s, column, l);
    const Real k = s.motion.mass[u] / (s.motion.dt * s.motion.dt);
    gradient[l] += k * (s.motion.x[u] - s.motion.x_inertial[u]);
    out.net += double(norm_squared(gradient[l]));
  }
  out.load = double(load) * double(load);
  solve_column(s.layered.columns, s.layered.rows, column, lumen.hessian, gradient, out.move);
  return out;
}

/// Moves a column. @return the part of the move that contact has withheld, squared [mm^2]
template <class Team, class Real, class Lanes>
ANGIO_HOST_DEVICE inline Real take_column(const StepView<Real>& s, int v, const Lanes& lanes,
                                          const ColumnMove<Real>& proposed) {
  const int column = v - s.bodies.wall().first;
  const Real borne = borne_share(s.layered.solid, s.layered.columns, s.layered.rows, column,
                                 proposed.move, Real(1));
  const Vec3T<Real> wanted = borne * proposed.move[0];
  const Real bounded = bounded_share<Team>(s, v, wanted), share = bounded * borne;
  move_patches(s.layered.solid, s.layered.columns, s.layered.rows, column, share, proposed.move,
               lanes);
  lanes.sync();
  if (lanes.rank() == 0) {
    move_wall_vertex(s, v, share * proposed.move[0]);
    for (int l = 1; l < s.layered.columns.levels; ++l)
      s.motion.x[column_vertex(s, column, l)] += share * proposed.move[l];
  }
  return norm_squared((Real(1) - bounded) * wanted);
}

/// After a motion of all bodies at once: puts the wall back if a point of it was strained by more
/// than a move may. @param before  by vertex of the step
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void take_back_if_strained(Team& team, const StepView<Real>& s,
                                                    const Vec3T<Real>* before) {
  const int first = s.bodies.wall().first;
  const SolidView<Real>& solid = s.layered.solid;
  double lost[1];
  team.template quick_sum<1, 1>(
      s.layered.wedge_count,
      [&](int w, const auto&, auto* part) {
        Vec3T<Real> x[6], was[6];
        solid.gather(w, x);
        for (int a = 0; a < 6; ++a) was[a] = before[first + solid.corners[6 * w + a]];
        part[0] += bears_move(solid.wedge(w), was, x) ? Real(0) : Real(1);
      },
      lost);
  if (!(lost[0] > 0.0)) return;
  team.template for_each<1>(s.bodies.wall().count * s.layered.columns.levels,
                            [&](int i, const auto&) { s.motion.x[first + i] = before[first + i]; });
  team.barrier();
}

/// Lets a wedge's points flow at the positions reached: F_e <- F_e G^-1 is g_a <- G^-T g_a. A wedge
/// that was well below its yield stress when its force was taken, and has hardly been strained
/// since, is not asked; should it yield yet, the next step, which takes its force again, sees it.
template <class Real>
ANGIO_HOST_DEVICE inline void flow_wedge(const StepView<Real>& s, int w) {
  const SolidWedge<Real> wedge = s.layered.solid.wedge(w);
  if (!(wedge.law.yield > Real(0))) return;
  Vec3T<Real> x[6];
  s.layered.solid.gather(w, x);
  const WedgePlace<Real>& place = s.layered.rows.places[w];
  if (place.has_force && !place.may_flow && !has_moved(place.x, x, Real(2.0 * kForceStrain)))
    return;
  for (int q = 0; q < kWedgePoints; ++q) {
    SolidPoint<Real>& point = s.layered.points[kWedgePoints * w + q];
    const FlowStep<Real> step =
        flow_solid(wedge.law, wedge.fiber, solid::deformation(point, x), s.motion.dt);
    if (!(step.strain > Real(0))) continue;
    const Mat3T<Real> back = transpose(inverse(step.growth));
    for (int a = 0; a < 6; ++a) point.g[a] = back * point.g[a];
    s.layered.plastic_strain[kWedgePoints * w + q] += step.strain;
    s.layered.rows.places[w].flowed += step.strain;
    s.layered.rows.places[w].has_force = false;
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
        part[2] += take_column<Team>(s, first + i, lanes, column);
      },
      total);
}

}  // namespace angio::simulation::detail
