#pragma once

#include "simulation/detail/gas.hpp"
#include "simulation/detail/step_balloon.hpp"
#include "simulation/detail/step_wall.hpp"

/// Balloon, wall and gas moved together: a Newton step on all vertices at once, its linear system
/// solved in part by conjugate gradients.
///
/// Sweeps move one vertex against the others. A balloon that lies on its wall is pressed against it
/// by a contact hundreds of times stiffer than the wall, so that sweeps move both on together by a
/// hundredth of the way; a joint step takes them there. It is only a better place for the next
/// sweep to begin at: convergence is judged by the sweeps.
///
/// The stiffness is that of the skin (exact), the pairs (barrier along the gap, friction across),
/// the gas (dp/dV), the wall's springs, tissue and slabs, these with their best rigid motion taken
/// out, and inertia. Preconditioned by the vertices' own 3 x 3 blocks. Source of the recurrences,
/// with one sum an iteration: Chronopoulos, Gear, J. Comput. Appl. Math. 25 (1989), 153-168.
namespace angio::simulation::detail {

/// How a triangle's energy answers to a motion, seen from a corner: derivatives by the squares and
/// the product of its edges.
template <class Real>
ANGIO_HOST_DEVICE inline SkinTangent<Real> skin_tangent(const StepView<Real>& s, int v, int c) {
  const Vec3T<Real> next = s.x[s.corners[c].next];
  const Vec3T<Real> e1 = s.x[v] - next, e2 = s.x[s.corners[c].last] - next;
  MetricSlopes<Real> t = metric_slopes(s.rest[c], skin_energy(s.skin, s.rest[c], e1, e2), e1, e2);
  SkinTangent<Real> out{t.a, t.b, t.aa, t.ab, t.ac, t.bb, t.bc};
  if (!s.skin.relaxed) return out;
  t = metric_slopes(s.start_rest[c], fold_energy(s, s.start_rest[c], e1, e2), e1, e2);
  return {out.a + t.a,   out.b + t.b,   out.aa + t.aa, out.ab + t.ab,
          out.ac + t.ac, out.bb + t.bb, out.bc + t.bc};
}

/// Change of the energy's gradient at corner v by a motion z.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> skin_product(const StepView<Real>& s, int v, int c,
                                                  const Vec3T<Real>* z) {
  const int next = s.corners[c].next, last = s.corners[c].last;
  const SkinTangent<Real>& t = s.skin_tangents[c];
  const Vec3T<Real> e1 = s.x[v] - s.x[next], e2 = s.x[last] - s.x[next];
  const Vec3T<Real> d1 = z[v] - z[next], d2 = z[last] - z[next];
  const Real a = Real(2) * dot(e1, d1), b = dot(e1, d2) + dot(e2, d1), cc = Real(2) * dot(e2, d2);
  return Real(2) * t.a * d1 + t.b * d2 + (Real(2) * (t.aa * a + t.ab * b + t.ac * cc)) * e1 +
         (t.ab * a + t.bb * b + t.bc * cc) * e2;
}

/// A slab member's place from the slab's centre, as the slab lies now.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> turned_offset(const StepView<Real>& s, int c, int e) {
  Vec3T<Real> r = s.cluster_map[c] * s.cluster_offset[e];
  if (s.entry_modes)
    for (int k = 0; k < kShapeModes; ++k)
      r += s.entry_modes[e * kShapeModes + k] * s.cluster_map_modes[c * kShapeModes + k];
  return r;
}

/// Prepares the rotation that follows a slab's motion: the inverse of sum k (r.r I - r r^T).
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void prepare_slab(const StepView<Real>& s, int c, const Lanes& lanes) {
  Mat3T<Real> inertia;
  Real weight = 0;
  for (int e = s.cluster_begin[c] + lanes.rank(); e < s.cluster_begin[c + 1]; e += lanes.size()) {
    const Vec3T<Real> r = turned_offset(s, c, e);
    inertia += s.cluster_stiffness[e] * (norm_squared(r) * Mat3T<Real>::identity() - outer(r, r));
    weight += s.cluster_stiffness[e];
  }
  inertia = sum_over_symmetric(lanes, inertia);
  weight = lanes.sum(weight);
  lanes.sync();
  if (lanes.rank() > 0) return;
  s.slab_inertia[c] = inverse_block(inertia);
  s.slab_weight[c] = weight;
}

/// The rigid motion of a slab nearest to a motion z of its members.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void move_slab(const StepView<Real>& s, int c, const Vec3T<Real>* z,
                                        const Lanes& lanes) {
  Vec3T<Real> shift, spin;
  for (int e = s.cluster_begin[c] + lanes.rank(); e < s.cluster_begin[c + 1]; e += lanes.size()) {
    const Vec3T<Real> d = s.cluster_stiffness[e] * z[s.balloon_count + s.cluster_vertex[e]];
    shift += d;
    spin += cross(turned_offset(s, c, e), d);
  }
  shift = sum_over(lanes, shift) / s.slab_weight[c];
  spin = s.slab_inertia[c] * sum_over(lanes, spin);
  lanes.sync();
  if (lanes.rank() > 0) return;
  s.slab_shift[c] = shift;
  s.slab_spin[c] = spin;
}

/// The force that a motion z takes from a pair, on a corner of weight 1.
template <class Real>
ANGIO_HOST_DEVICE inline void move_pair(const StepView<Real>& s, int p, const Vec3T<Real>* z) {
  PairTangent<Real>& tangent = s.pair_tangents[p];
  if (!(tangent.along > Real(0))) return;
  const NearPair<Real>& pair = s.pairs[p];
  Vec3T<Real> gap;
  for (int i = 0; i < 4; ++i) gap += pair.weights.w[i] * z[pair.vertex[i]];
  const Vec3T<Real> normal = dot(gap, pair.direction) * pair.direction;
  tangent.product = tangent.along * normal + tangent.across * (gap - normal);
}

/// A lane's share of what the pairs of a vertex add.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> pair_products(const StepView<Real>& s, int v,
                                                   const Lanes& lanes) {
  Vec3T<Real> sum;
  for (int r = s.ref_begin[v] + lanes.rank(); r < s.ref_end[v]; r += lanes.size()) {
    const int p = s.refs[r].pair;
    const PairTangent<Real>& tangent = s.pair_tangents[p];
    if (tangent.along > Real(0)) sum += s.pairs[p].weights.w[s.refs[r].corner] * tangent.product;
  }
  return sum;
}

/// Stiffness times a motion z at a vertex of the balloon, but for the gas.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> balloon_product(const StepView<Real>& s, int v,
                                                     const Vec3T<Real>* z, const Lanes& lanes) {
  Vec3T<Real> sum = pair_products(s, v, lanes);
  for (int c = s.corner_begin[v] + lanes.rank(); c < s.corner_begin[v + 1]; c += lanes.size())
    sum += skin_product(s, v, c, z);
  return sum_over(lanes, sum) + (s.mass[v] / (s.dt * s.dt)) * z[v];
}

/// The same at a vertex of the wall.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> wall_product(const StepView<Real>& s, int v,
                                                  const Vec3T<Real>* z, const Lanes& lanes) {
  const int i = v - s.balloon_count;
  Vec3T<Real> sum = pair_products(s, v, lanes);
  for (int n = s.neighbor_begin[i] + lanes.rank(); n < s.neighbor_begin[i + 1]; n += lanes.size()) {
    const int u = s.neighbors[n];
    const Real spring =
        Real(0.5 * kWallSmoothing) * (s.goal_stiffness[i] + s.goal_stiffness[u - s.balloon_count]);
    sum += spring * (z[v] - z[u]);
  }
  for (int n = s.entry_begin[i] + lanes.rank(); n < s.entry_begin[i + 1]; n += lanes.size()) {
    const int e = s.entry[n], c = s.entry_cluster[e];
    sum -=
        s.cluster_stiffness[e] * (s.slab_shift[c] + cross(s.slab_spin[c], turned_offset(s, c, e)));
  }
  return sum_over(lanes, sum) +
         (s.goal_stiffness[i] + s.foundation[i] + s.mass[v] / (s.dt * s.dt)) * z[v];
}

}  // namespace angio::simulation::detail
