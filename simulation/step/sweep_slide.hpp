#pragma once

#include "simulation/step/sweep_balloon.hpp"

/// The step's distal neck: it slides along the wire as one body, driven by the membrane's pull, the
/// gas and contact,
///
///     q = sum t . f / sum t . H t,   over its vertices, t the wire's direction.
///
/// It leaves out what couples two vertices of the neck: of a triangle with two of them, (a + b)^2
/// <= 2 (a^2 + b^2), so q is less than twice Newton's step, and the energy falls.
namespace angio::simulation::detail {

/// Moves the neck by q t, all of it by the share that the vertex with the least room may take.
/// @return the share
template <class Real, class Team>
ANGIO_HOST_DEVICE inline Real take_slide(Team& team, const StepView<Real>& s, Real q) {
  const SlideView<Real>& slide = s.slide;
  const Vec3T<Real> move = q * slide.along;
  team.template for_each<1>(slide.count, [&](int i, const auto&) {
    slide.loads[i].share = bounded_share<Team>(s, slide.vertices[i], move);
  });
  team.barrier();
  Real least = Real(1);
  for (int i = 0; i < slide.count; ++i)
    least = slide.loads[i].share < least ? slide.loads[i].share : least;
  team.template for_each<1>(
      slide.count, [&](int i, const auto&) { s.motion.x[slide.vertices[i]] += least * move; });
  team.barrier();
  return least;
}

/// Moves the neck outside a sweep. @return is it held by its bounds?
template <class Real, class Team>
ANGIO_HOST_DEVICE inline bool slide_by(Team& team, const StepView<Real>& s, Real q) {
  return take_slide(team, s, q) < Real(1);
}

/// The neck's part of a sweep.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void sweep_slide(Team& team, const StepView<Real>& s, StepStatus& status,
                                          SweepSums& sums) {
  const SlideView<Real>& slide = s.slide;
  const Real gauge = Real(status.pressure) - s.balloon.outside_pressure;
  team.template for_each<Team::kBalloonLanes>(slide.count, [&](int i, const auto& lanes) {
    Vec3T<Real> by_volume;
    const VertexForces<Real> f =
        balloon_forces<Team::kSurroundings>(s, slide.vertices[i], lanes, by_volume);
    lanes.sync();
    if (lanes.rank() != 0) return;
    const Vec3T<Real>& t = slide.along;
    slide.loads[i] = {dot(t, f.force + gauge * by_volume), dot(t, f.hessian * t), dot(t, by_volume),
                      f.contact, Real(1)};
  });
  team.barrier();
  double force = 0.0, stiffness = 0.0, load = 0.0, area = 0.0;
  for (int i = 0; i < slide.count; ++i) {
    const SlideLoad<Real>& on = slide.loads[i];
    force += double(on.force);
    stiffness += double(on.stiffness);
    area += double(on.by_volume);
    load += double(gauge * on.by_volume) * double(gauge * on.by_volume) +
            double(on.magnitude) * double(on.magnitude);
  }
  team.barrier();
  sums.net += force * force;
  sums.load += load;
  if (!(stiffness > 0.0)) return;
  const Real q = Real(force / stiffness), share = take_slide(team, s, q);
  const double gone = double(share * q);
  status.volume += gone * area;
  status.pressure = pressure_at(status.law, status.volume);
  sums.moved += slide.count * gone * gone;
  const double held = double(q) - gone;
  sums.withheld += slide.count * held * held;
}

}  // namespace angio::simulation::detail
