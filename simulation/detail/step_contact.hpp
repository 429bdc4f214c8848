#pragma once

#include "simulation/detail/step_state.hpp"

/// The step's contact: pairs, their forces, and how far a vertex may go.
namespace angio::simulation::detail {

/// Recomputes a pair's closest points and weight at the present positions.
template <class Real>
ANGIO_HOST_DEVICE inline void refresh_pair(const StepView<Real>& s, int index) {
  NearPair<Real>& pair = s.pairs[index];
  const Vec3T<Real> p[4] = {s.x[pair.vertex[0]], s.x[pair.vertex[1]], s.x[pair.vertex[2]],
                            s.x[pair.vertex[3]]};
  pair.weights = pair.edges ? segment_segment_gap(p[0], p[1], p[2], p[3])
                            : point_triangle_gap(p[0], p[1], p[2], p[3]);
  Vec3T<Real> gap;
  for (int i = 1; i < 4; ++i) gap += pair.weights.w[i] * (p[i] - p[0]);  // the weights sum to 0
  const Real d = norm(gap);
  pair.direction = d > Real(0) ? gap / d : pair.normal;
  pair.gap = d;
  pair.film = Real(0);
  // A pair just out of contact is kept ready for the motion of one sweep.
  const bool near = d < Real(1.5) * s.contact_distance;
  const Real fade = pair.edges ? sine_squared(p[1] - p[0], p[3] - p[2]) : Real(1);
  pair.weight = near ? pair.area * fade : Real(0);
}

/// The nearest triangle before a vertex, among its pairs; null: there is none.
template <class Real>
ANGIO_HOST_DEVICE inline NearPair<Real>* nearest_face(const StepView<Real>& s, int v) {
  NearPair<Real>* nearest = nullptr;
  for (int r = s.ref_begin[v]; r < s.ref_begin[v + 1]; ++r) {
    NearPair<Real>& pair = s.pairs[s.refs[r].pair];
    if (s.refs[r].corner != 0 || pair.edges) continue;
    if (!nearest || pair.gap < nearest->gap) nearest = &pair;
  }
  return nearest;
}

/// Puts a wet vertex's film before the nearest triangle; after all pairs are renewed.
template <class Real>
ANGIO_HOST_DEVICE inline void refresh_film(const StepView<Real>& s, int v) {
  if (!s.wet[v]) return;
  NearPair<Real>* nearest = nearest_face(s, v);
  if (nearest) nearest->film = nearest->area;
}

/// Wets or dries a vertex at the end of a step.
template <class Real>
ANGIO_HOST_DEVICE inline void flow_film(const StepView<Real>& s, int v) {
  const NearPair<Real>* nearest = nearest_face(s, v);
  s.wet[v] = nearest && stays_wet(s.adhesion, s.wet[v] != 0, nearest->gap) ? 1 : 0;
}

/// Adds a pair's film to its corner with weight w, at a gap d along n. Where the film gives way its
/// stiffness is negative and left out: the step is then short, never the wrong way.
template <class Real>
ANGIO_HOST_DEVICE inline void add_film(const StepView<Real>& s, const NearPair<Real>& pair, Real w,
                                       const Vec3T<Real>& n, Real d, VertexForces<Real>& out) {
  const FilmPull<Real> pull = film_pull(s.adhesion, d);
  const Vec3T<Real> force = (-pull.traction * pair.film * w) * n;
  out.force += force;
  out.adhesion += force;
  out.magnitude += norm(force);
  if (pull.stiffness > Real(0)) out.hessian += outer((pull.stiffness * pair.film * w * w) * n, n);
}

/// Adds the barrier, the friction and the film of a vertex's pairs, each lane its share of them.
///
/// Within a sweep a gap is taken along its last direction with its last weights, d = n . sum w_i
/// x_i (exact to first order); refresh_pair renews both before each sweep.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void add_contact(const StepView<Real>& s, int v, const Lanes& lanes,
                                          VertexForces<Real>& out) {
  for (int r = s.ref_begin[v] + lanes.rank(); r < s.ref_begin[v + 1]; r += lanes.size()) {
    const NearPair<Real>& pair = s.pairs[s.refs[r].pair];
    const Real w = pair.weights.w[s.refs[r].corner];
    if (!(pair.weight + pair.film > Real(0)) || w == Real(0)) continue;
    const Vec3T<Real> n = pair.direction, base = s.x[pair.vertex[0]];
    Vec3T<Real> gap;
    for (int i = 1; i < 4; ++i) gap += pair.weights.w[i] * (s.x[pair.vertex[i]] - base);
    const Real least = Real(0.05) * s.contact_distance;
    Real d = dot(n, gap);
    if (pair.film > Real(0)) add_film(s, pair, w, n, d, out);
    if (!(pair.weight > Real(0)) || d >= s.contact_distance) continue;
    d = d > least ? d : (norm(gap) < least ? norm(gap) : least);
    const Barrier<Real> b = barrier(d, s.contact_distance);
    const Real scale = s.contact_stiffness * pair.weight;
    const Real normal_force = -scale * b.slope, share = w < Real(0) ? -w : w;
    out.touching = true;
    out.contact += normal_force * share;
    out.force += (normal_force * w) * n;
    out.magnitude += normal_force * share;
    const Real stiffness = scale * b.curvature * w * w;
    const Vec3T<Real> base_before = s.x_before[pair.vertex[0]];
    Vec3T<Real> slip = gap;
    for (int i = 1; i < 4; ++i)
      slip -= pair.weights.w[i] * (s.x_before[pair.vertex[i]] - base_before);
    slip -= dot(slip, n) * n;
    const Real rub = normal_force * friction_per_slip(s.friction, norm(slip));
    const Vec3T<Real> friction = (-rub * w) * slip;
    out.force += friction;
    out.friction += friction;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        out.hessian(i, j) +=
            stiffness * n[i] * n[j] + rub * w * w * ((i == j ? Real(1) : Real(0)) - n[i] * n[j]);
  }
}

/// The longest part of a move that keeps the vertex within its bounds since the last detection.
/// @return share in [0, 1]
template <class Real>
ANGIO_HOST_DEVICE inline Real allowed_share(const StepView<Real>& s, int v,
                                            const Vec3T<Real>& move) {
  using std::sqrt;
  const Vec3T<Real> done = s.x[v] - s.x_detected[v];
  Real share = Real(1);
  for (int b = s.bound_begin[v]; b < s.bound_begin[v + 1]; ++b) {
    const MotionBound<Real>& bound = s.bounds[b];
    const Real more = -dot(bound.normal, move);
    if (!(more > Real(0))) continue;
    const Real left = bound.limit + dot(bound.normal, done);
    if (more > left) {
      const Real part = left > Real(0) ? left / more : Real(0);
      share = part < share ? part : share;
    }
  }
  // |done + t move| <= travel
  const Real a = dot(move, move), b = dot(done, move), c = dot(done, done) - s.travel * s.travel;
  if (a + Real(2) * b + c > Real(0)) {
    const Real root = b * b - a * c;
    Real part = root > Real(0) && a > Real(0) ? (-b + sqrt(root)) / a : Real(0);
    part = part > Real(0) ? part : Real(0);
    share = part < share ? part : share;
  }
  return share;
}

}  // namespace angio::simulation::detail
