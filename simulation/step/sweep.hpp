#pragma once

#include "simulation/pbd/sweep.hpp"
#include "simulation/step/sweep_balloon.hpp"
#include "simulation/step/sweep_guidewire.hpp"
#include "simulation/step/sweep_layered_wall.hpp"
#include "simulation/step/sweep_slabs.hpp"
#include "simulation/step/sweep_slide.hpp"

/// A sweep over all bodies.
namespace angio::simulation::detail {

/// Fits the wall's slabs and its goals, and renews the contact pairs.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void refresh(Team& team, const StepView<Real>& s) {
  if (!Team::kSurroundings || (!has_pairs<Team>(s) && s.bodies.wall().count == 0)) return;
  if (s.contact.candidates.count > 0) {
    team.template for_each<1>(s.bodies.contact_count(), [&](int i, const auto&) {
      const int v = s.bodies.contact_vertex(i);
      s.contact.near.moved[v] = norm(s.motion.x[v] - s.motion.x_searched[v]);
    });
    team.barrier();
  }
  team.template for_each<Team::kVertexLanes>(
      s.contact.candidates.count > 0 ? s.bodies.contact_count() : 0, [&](int i, const auto& lanes) {
        const int v = s.bodies.contact_vertex(i);
        for (int p = s.contact.candidates.owned_begin[v] + lanes.rank();
             p < s.contact.near.owned_end[v]; p += lanes.size())
          refresh_pair(s, p);
      });
  team.template for_each<Team::kSlabLanes>(
      s.slabs.count, [&](int c, const auto& lanes) { fit_slab(s, c, lanes); });
  team.barrier();
  if (s.slabs.count > 0)
    team.template for_each<1>(s.bodies.wall().count, [&](int i, const auto&) { set_goal(s, i); });
  if (s.contact.wet && s.contact.candidates.count > 0)
    team.template for_each<1>(s.bodies.surface_count(),
                              [&](int v, const auto&) { refresh_film(s, v); });
  team.barrier();
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void sweep_wall(Team& team, const StepView<Real>& s, int sweep,
                                         SweepSums& sums) {
  const double net_before = sums.net, load_before = sums.load;
  if constexpr (Team::kSolids) {
    if (s.layered.columns.levels > 0) renew_columns(team, s, sweep);
  }
  for (int color = 0; color < s.wall.mesh.colors; ++color) {
    const int first = s.wall.mesh.color_begin[color],
              count = s.wall.mesh.color_begin[color + 1] - first;
    double total[3];
    bool layered = false;
    if constexpr (Team::kSolids) {
      layered = s.layered.columns.levels > 0;
      if (layered) move_wall_columns(team, s, first, count, total);
    }
    if (!layered) move_wall_vertices(team, s, first, count, total);
    make_wall_moves(team, s, first, count);
    sums.net += total[0];
    sums.load += total[1];
    sums.withheld += total[2];
  }
  sums.wall_net = sums.net - net_before;
  sums.wall_load = sums.load - load_before;
}

/// One sweep over balloon and wall.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline SweepSums sweep(Team& team, const StepView<Real>& s, bool wall,
                                         StepStatus& status) {
  SweepSums sums;
  StepTimes& times = status.report.times;
  const double begin = team.now();
  refresh(team, s);
  const double refreshed = team.now();
  sweep_balloon(team, s, status, sums);
  if (Team::kSurroundings && s.guidewire.shape.count > 0) sweep_rod(team, s, status, sums);
  if (s.slide.count > 0) sweep_slide(team, s, status, sums);
  const double swept = team.now();
  if (Team::kSurroundings && wall) sweep_wall(team, s, status.report.sweeps, sums);
  if constexpr (Team::kSolids) project_pbd(team, s, status);
  times.refresh += refreshed - begin;
  times.balloon += swept - refreshed;
  times.wall += team.now() - swept;
  return sums;
}

}  // namespace angio::simulation::detail
