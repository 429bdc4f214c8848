#pragma once

#include "simulation/step/sweep_balloon.hpp"

/// The step's guidewire: a rod inside the balloon, whose fixed vertices are tied to it.
///
/// Its nodes are one block of the descent, solved at once: bending couples them so stiffly that
/// sweeps vertex by vertex would take thousands to straighten 24 of them. The team gathers what
/// acts on nodes and ties, one thread puts the block together and solves it, and the team takes the
/// moves, all of them by the share that the one with the least room may take.
namespace angio::simulation::detail {

/// Nodes and ties.
template <class Real>
ANGIO_HOST_DEVICE inline int rod_part_count(const GuidewireView<Real>& rod) {
  return rod.shape.count + rod.tie_count;
}

template <class Real>
ANGIO_HOST_DEVICE inline int rod_part_vertex(const GuidewireView<Real>& rod, int part) {
  return part < rod.shape.count ? rod.first + part : rod.ties[part - rod.shape.count].vertex;
}

/// What acts on a node or a tied vertex from outside the rod.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void gather_rod_load(const StepView<Real>& s, int part, const Lanes& lanes,
                                              Real gauge) {
  const int v = rod_part_vertex(s.guidewire, part);
  RodLoad<Real> load;
  VertexForces<Real> f;
  if (part < s.guidewire.shape.count) {
    if (s.contact.candidates.count > 0) add_contact(s, v, lanes, f);
    gather(s, lanes, f);
    add_inertia(s, v, f);
  } else {
    f = balloon_forces<true>(s, v, lanes, load.by_volume);
    f.force += gauge * load.by_volume;
  }
  load.force = f.force;
  load.hessian = f.hessian;
  load.magnitude = f.contact;
  lanes.sync();
  if (lanes.rank() == 0) s.guidewire.loads[part] = load;
}

template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<double> in_double(const Mat3T<Real>& a) {
  Mat3T<double> b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) b(i, j) = double(a(i, j));
  return b;
}

/// The external loads as rows of the block; x gets the nodes' positions.
template <class Real>
ANGIO_HOST_DEVICE inline void put_rod_loads(const StepView<Real>& s) {
  const GuidewireView<Real>& rod = s.guidewire;
  for (int i = 0; i < rod.shape.count; ++i) {
    rod.x[i] = in_double(s.motion.x[rod.first + i]);
    rod.external[i] = {};
    rod.external[i].force = in_double(rod.loads[i].force);
    rod.external[i].own = in_double(rod.loads[i].hessian);
  }
  for (int k = 0; k < rod.tie_count; ++k) {
    const RodTie& tie = rod.ties[k];
    const RodLoad<Real>& load = rod.loads[rod.shape.count + k];
    const double b = tie.share, a = 1.0 - b;
    const Vec3T<double> force = in_double(load.force);
    const Mat3T<double> hessian = in_double(load.hessian);
    RodRow<double>&row = rod.external[tie.node], &next = rod.external[tie.node + 1];
    row.force += a * force;
    next.force += b * force;
    row.own += (a * a) * hessian;
    next.own += (b * b) * hessian;
    row.next += (a * b) * hessian;
  }
}

/// The rod's energy and the loads' quadratic model after a share of the moves in `rows` [nJ].
template <class Real>
ANGIO_HOST_DEVICE inline double rod_energy_after(const GuidewireView<Real>& rod, double share) {
  Vec3T<double>* at = rod.x + rod.shape.count;
  double energy = 0.0;
  for (int i = 0; i < rod.shape.count; ++i) {
    const Vec3T<double> move = share * rod.rows[i].force;
    const RodRow<double>& load = rod.external[i];
    at[i] = rod.x[i] + move;
    energy += dot(move, 0.5 * (load.own * move) - load.force);
    if (i + 1 < rod.shape.count) energy += dot(move, load.next * (share * rod.rows[i + 1].force));
  }
  return energy + rod_energy(rod.shape, rod.section, at);
}

/// One Newton step of the rod under what acts on it, by one thread: `rows` ends with the moves.
template <class Real>
ANGIO_HOST_DEVICE ANGIO_OUT_OF_LINE void propose_rod(const StepView<Real>& s) {
  const GuidewireView<Real>& rod = s.guidewire;
  const int count = rod.shape.count;
  put_rod_loads(s);
  for (int i = 0; i < count; ++i) rod.rows[i] = rod.external[i];
  add_rod(rod.shape, rod.section, rod.x, rod.rows);
  RodReport report;
  for (int i = 0; i < rod_part_count(rod); ++i) {
    const RodLoad<Real>& load = rod.loads[i];
    report.load += double(load.magnitude) * double(load.magnitude);
  }
  for (int i = 0; i < count; ++i) {
    if (rod.held[i]) hold_node(i, rod.rows);
    report.net += norm_squared(rod.rows[i].force);
  }
  solve_rod(count, rod.rows);
  const double before = rod_energy_after(rod, 0.0);
  double share = 1.0;
  constexpr int kHalvings = 8;
  for (int h = 0; h < kHalvings && !(rod_energy_after(rod, share) <= before); ++h) share *= 0.5;
  for (int i = 0; i < count; ++i) rod.rows[i].force *= share;
  *rod.report = report;
}

/// Of the moves in `rows`.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> rod_move(const GuidewireView<Real>& rod, int part) {
  Vec3T<double> move;
  if (part < rod.shape.count) {
    move = rod.rows[part].force;
  } else {
    const RodTie& tie = rod.ties[part - rod.shape.count];
    move = (1.0 - tie.share) * rod.rows[tie.node].force + tie.share * rod.rows[tie.node + 1].force;
  }
  return {Real(move.x), Real(move.y), Real(move.z)};
}

/// Takes the rod's moves: nodes and ties by one share, that of the least room.
/// @return volume gained [mm^3]
template <class Real, class Team>
ANGIO_HOST_DEVICE inline double take_rod(Team& team, const StepView<Real>& s) {
  const GuidewireView<Real>& rod = s.guidewire;
  const int parts = rod_part_count(rod);
  team.template for_each<1>(parts, [&](int i, const auto&) {
    rod.share[i] = bounded_share<Team>(s, rod_part_vertex(rod, i), rod_move(rod, i));
  });
  team.barrier();
  if (team.leader()) {
    Real least = Real(1);
    for (int i = 0; i < parts; ++i) least = rod.share[i] < least ? rod.share[i] : least;
    rod.report->share = double(least);
  }
  team.barrier();
  const Real share = Real(rod.report->share);
  double total[2];
  team.template sum<1, 2>(
      parts,
      [&](int i, const auto&, auto* part) {
        const Vec3T<Real> wanted = rod_move(rod, i), move = share * wanted;
        s.motion.x[rod_part_vertex(rod, i)] += move;
        if (i >= rod.shape.count) part[0] += dot(rod.loads[i].by_volume, move);
        part[1] += norm_squared(wanted - move);
      },
      total);
  if (team.leader()) rod.report->withheld = total[1];
  team.barrier();
  return total[0];
}

/// Moves the guidewire and what is tied to it.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void sweep_rod(Team& team, const StepView<Real>& s, StepStatus& status,
                                        SweepSums& sums) {
  const Real gauge = Real(status.pressure) - s.balloon.outside_pressure;
  team.template for_each<Team::kVertexLanes>(
      rod_part_count(s.guidewire),
      [&](int i, const auto& lanes) { gather_rod_load(s, i, lanes, gauge); });
  team.barrier();
  if (team.leader()) propose_rod(s);
  team.barrier();
  status.volume += take_rod(team, s);
  status.pressure = pressure_at(status.law, status.volume);
  sums.net += s.guidewire.report->net;
  sums.load += s.guidewire.report->load;
  sums.withheld += s.guidewire.report->withheld;
  team.barrier();
}

}  // namespace angio::simulation::detail
