#pragma once

#include "simulation/step/near_pairs.hpp"

/// What acts between near pairs: the barrier, friction, and the film of blood.
namespace angio::simulation::detail {

/// Recomputes a pair's closest points and weight at the present positions, `moved` from the last
/// search, unless it is too far for anything to act.
template <class Real>
ANGIO_HOST_DEVICE inline void refresh_pair(const StepView<Real>& s, int index) {
  NearPair<Real>& pair = s.contact.near.pairs[index];
  // A pair just out of contact is kept ready for the motion of one sweep.
  const Real ready = Real(1.5) * pair.distance, range = range_of(s, pair);
  pair.film = pair.weight = Real(0);
  pair.gap = pair.gap_searched - closed_at_most(s, pair);
  if (pair.gap >= (ready > range ? ready : range)) return;
  const Vec3T<Real> p[4] = {s.motion.x[pair.vertex[0]], s.motion.x[pair.vertex[1]],
                            s.motion.x[pair.vertex[2]], s.motion.x[pair.vertex[3]]};
  pair.weights = closest_points(pair, p);
  const Vec3T<Real> before[4] = {
      s.motion.x_before[pair.vertex[0]], s.motion.x_before[pair.vertex[1]],
      s.motion.x_before[pair.vertex[2]], s.motion.x_before[pair.vertex[3]]};
  const Vec3T<Real> gap = weighted_gap(pair.weights, p);
  pair.gap_before = weighted_gap(pair.weights, before);
  const Real d = norm(gap);
  pair.direction = d > Real(0) ? gap / d : pair.normal;
  pair.gap = d - pair.radius;
  if (pair.gap < ready)
    pair.weight = pair.area * (pair.edges ? sine_squared(p[1] - p[0], p[3] - p[2]) : Real(1));
}

/// The nearest triangle before a vertex, among the pairs that it owns; null: there is none.
template <class Real>
ANGIO_HOST_DEVICE inline NearPair<Real>* nearest_face(const StepView<Real>& s, int v) {
  NearPair<Real>* nearest = nullptr;
  for (int p = s.contact.candidates.owned_begin[v]; p < s.contact.near.owned_end[v]; ++p) {
    NearPair<Real>& pair = s.contact.near.pairs[p];
    if (pair.edges || pair.shaft || pair.self) continue;
    if (!nearest || pair.gap < nearest->gap) nearest = &pair;
  }
  return nearest;
}

/// Puts a wet vertex's film before the nearest triangle; after all pairs are renewed.
template <class Real>
ANGIO_HOST_DEVICE inline void refresh_film(const StepView<Real>& s, int v) {
  if (!s.contact.wet[v]) return;
  NearPair<Real>* nearest = nearest_face(s, v);
  if (nearest && nearest->gap < s.contact.law.range) nearest->film = nearest->area;
}

/// Wets or dries a vertex at the end of a step.
template <class Real>
ANGIO_HOST_DEVICE inline void flow_film(const StepView<Real>& s, int v) {
  const NearPair<Real>* nearest = nearest_face(s, v);
  s.contact.wet[v] =
      nearest && stays_wet(s.contact.law.adhesion, s.contact.wet[v] != 0, nearest->gap) ? 1 : 0;
}

/// Adds a pair's film to its corner with weight w, at a gap d along n. Where the film gives way its
/// stiffness is negative and left out: the step is then short, never the wrong way.
template <class Real>
ANGIO_HOST_DEVICE inline void add_film(const StepView<Real>& s, const NearPair<Real>& pair, Real w,
                                       const Vec3T<Real>& n, Real d, VertexForces<Real>& out) {
  const FilmPull<Real> pull = film_pull(s.contact.law.adhesion, d);
  const Vec3T<Real> force = (-pull.traction * pair.film * w) * n;
  out.force += force;
  out.adhesion += force;
  out.magnitude += norm(force);
  if (pull.stiffness > Real(0)) out.hessian += outer((pull.stiffness * pair.film * w * w) * n, n);
}

/// What acts between the two sides of a pair.
template <class Real>
struct PairForces {
  bool touching = false;
  GapWeights<Real> weights;
  Vec3T<Real> direction;  // unit gap direction
  Real gap{};             // along it [mm]
  Real normal{};          // that parts them [uN]
  Real stiffness{};       // along the gap [uN/mm]
  Real rub{};             // friction per slip [uN/mm]
  Vec3T<Real> slip;       // in this step, of side a against side b [mm]
};

/// The gap at which a pair's barrier is infinite [mm]: the one that motions leave, so that the
/// barrier, no bound, carries what presses there.
template <class Real>
ANGIO_HOST_DEVICE inline Real closed_gap(const NearPair<Real>& pair) {
  return Real(pair.self ? kSelfLeastGap : kLeastGap) * pair.distance;
}

/// A pair that is pressed to this share of its range is deep: its force changes by as much as it is
/// with moves that are next to nothing to all others.
inline constexpr double kDeepShare = 0.05;
/// The least distance, as a share of a deep pair's, at which the barrier is asked.
inline constexpr double kLeastDepth = 1e-3;

/// Finds a pair's closest points where its corners p are now.
template <class Real>
ANGIO_HOST_DEVICE inline void find_closest_points(const NearPair<Real>& pair,
                                                  const Vec3T<Real> (&p)[4],
                                                  PairForces<Real>& out) {
  out.weights = closest_points(pair, p);
  const Vec3T<Real> gap = weighted_gap(out.weights, p);
  const Real distance = norm(gap);
  if (distance > Real(0)) out.direction = gap / distance;
  out.gap = distance - pair.radius;
}

/// Within a sweep a gap is taken along its last direction with its last weights, d = n . sum w_i
/// x_i (exact to first order); refresh_pair renews both before each sweep. Only a deep pair's
/// closest points are found each time.
template <class Real>
ANGIO_HOST_DEVICE inline PairForces<Real> pair_forces(const StepView<Real>& s,
                                                      const NearPair<Real>& pair) {
  PairForces<Real> out;
  out.weights = pair.weights;
  out.direction = pair.direction;
  const Vec3T<Real> p[4] = {s.motion.x[pair.vertex[0]], s.motion.x[pair.vertex[1]],
                            s.motion.x[pair.vertex[2]], s.motion.x[pair.vertex[3]]};
  const Vec3T<Real> gap = weighted_gap(pair.weights, p);
  out.gap = dot(out.direction, gap) - pair.radius;
  if (!(pair.weight > Real(0)) || out.gap >= pair.distance) return out;
  const Real closed = closed_gap(pair), range = pair.distance - closed,
             deep = Real(kDeepShare) * range;
  if (!(out.gap - closed > deep)) find_closest_points(pair, p, out);
  const Real least = Real(kLeastDepth) * deep,
             d = out.gap - closed > least ? out.gap - closed : least;
  const Barrier<Real> b = barrier(d, range);
  // The slope goes with the distance: any carries the same pressure at its half.
  const Real scale =
      s.contact.law.stiffness * (s.contact.law.distance / pair.distance) * pair.weight;
  out.touching = true;
  out.normal = -scale * b.slope;
  out.stiffness = scale * b.curvature;
  if (pair.shaft || pair.self)
    return out;  // a shaft slides in its balloon, wet folds on each other
  out.slip = gap - pair.gap_before;
  out.slip -= dot(out.slip, out.direction) * out.direction;
  out.rub = out.normal * friction_per_slip(s.contact.law.friction, norm(out.slip));
  return out;
}

/// Adds the barrier, the friction and the film of a vertex's pairs, each lane its share of them.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void add_contact(const StepView<Real>& s, int v, const Lanes& lanes,
                                          VertexForces<Real>& out) {
  for (int r = s.contact.candidates.ref_begin[v] + lanes.rank(); r < s.contact.near.ref_end[v];
       r += lanes.size()) {
    const NearPair<Real>& pair = s.contact.near.pairs[s.contact.near.refs[r].pair];
    const int corner = s.contact.near.refs[r].corner;
    const bool may_turn = pair.gap < Real(2.0 * kDeepShare) * pair.distance;
    if (!(pair.weight + pair.film > Real(0)) || (pair.weights.w[corner] == Real(0) && !may_turn))
      continue;
    const PairForces<Real> forces = pair_forces(s, pair);
    const Vec3T<Real> n = forces.direction;
    const Real w = forces.weights.w[corner];
    if (w == Real(0)) continue;
    if (pair.film > Real(0)) add_film(s, pair, w, n, forces.gap, out);
    if (!forces.touching) continue;
    const Real share = forces.normal * abs_of(w);
    out.touching = true;
    out.touching_wall = out.touching_wall || !(pair.shaft || pair.self);
    out.contact += share;
    out.magnitude += share;
    const Vec3T<Real> friction = (-forces.rub * w) * forces.slip;
    out.force += (forces.normal * w) * n + friction;
    if (pair.self) out.own += (forces.normal * w) * n;
    out.friction += friction;
    // With a twin that moves at the same time: (a u + b v)^2 <= (|a| + |b|) (|a| u^2 + |b| v^2).
    const int twin = pair.twin[corner];
    const Real both = w * w + (twin < 0 ? Real(0) : abs_of(w * forces.weights.w[twin]));
    const Real along = forces.stiffness * both, across = forces.rub * w * w;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        out.hessian(i, j) +=
            along * n[i] * n[j] + across * ((i == j ? Real(1) : Real(0)) - n[i] * n[j]);
  }
}

}  // namespace angio::simulation::detail
