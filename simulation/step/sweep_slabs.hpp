#pragma once

#include "simulation/step/near_pairs.hpp"

/// The step's wall by shape matching: what acts on its vertices, and its slabs.
namespace angio::simulation::detail {

/// A smoothing spring's share of its vertices' wall stiffness: the wall bends rather than being
/// pierced by a single vertex. A tube of 16 edges around gets 2 % stiffer by it.
inline constexpr double kWallSmoothing = 0.1;

/// Moves a vertex of the wall. Where the wall meets itself two vertices of a colour may be in one
/// pair: there none goes before all have looked (make_wall_moves).
template <class Real>
ANGIO_HOST_DEVICE inline void move_wall_vertex(const StepView<Real>& s, int v,
                                               const Vec3T<Real>& by) {
  if (s.self_distance > Real(0))
    s.wall_move[v - s.balloon_count] = by;
  else
    s.x[v] += by;
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void make_wall_moves(Team& team, const StepView<Real>& s, int first,
                                              int count) {
  if (!(s.self_distance > Real(0))) return;
  team.template for_each<1>(count, [&](int i, const auto&) {
    s.x[first + i] += s.wall_move[first + i - s.balloon_count];
  });
  team.barrier();
}

/// Everything on a vertex of the wall.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline VertexForces<Real> wall_forces(const StepView<Real>& s, int v,
                                                        const Lanes& lanes) {
  VertexForces<Real> out;
  const int i = v - s.balloon_count;
  const Vec3T<Real> off = s.x[v] - s.goal[i];
  Real k = 0;
  for (int n = s.neighbor_begin[i] + lanes.rank(); n < s.neighbor_begin[i + 1]; n += lanes.size()) {
    const int u = s.neighbors[n], j = u - s.balloon_count;
    const Real spring = Real(0.5 * kWallSmoothing) * (s.goal_stiffness[i] + s.goal_stiffness[j]);
    out.force -= spring * (off - (s.x[u] - s.goal[j]));
    k += spring;
  }
  for (int a = 0; a < 3; ++a) out.hessian(a, a) = k;
  if (s.candidate_count > 0) add_contact(s, v, lanes, out);
  gather(s, lanes, out);
  const Vec3T<Real> elastic =
      s.along_force[i] - s.along_stiffness[i] * off - s.goal_stiffness[i] * off;
  out.force += elastic;
  out.magnitude += norm(elastic);
  out.force += s.foundation[i] * (s.start[v] - s.x[v]);
  out.hessian += s.along_stiffness[i];
  for (int a = 0; a < 3; ++a) out.hessian(a, a) += s.goal_stiffness[i] + s.foundation[i];
  add_inertia(s, v, out);
  return out;
}

/// A member's place in the plastic shape of its cluster.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> plastic_offset(const StepView<Real>& s, int c, int e) {
  Vec3T<Real> q = s.cluster_plastic[c] * s.cluster_offset[e];
  if (s.entry_modes)
    for (int k = 0; k < kShapeModes; ++k)
      q += s.entry_modes[e * kShapeModes + k] * s.cluster_plastic_modes[c * kShapeModes + k];
  return q;
}

/// The coefficient of a mode in the cluster's best map.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> best_mode(const StepView<Real>& s, int c, int k,
                                               const Vec3T<Real>& centre, const Lanes& lanes) {
  Vec3T<Real> sum;
  for (int e = s.cluster_begin[c] + lanes.rank(); e < s.cluster_begin[c + 1]; e += lanes.size())
    sum += (s.cluster_stiffness[e] * s.entry_modes[e * kShapeModes + k]) *
           (s.x[s.balloon_count + s.cluster_vertex[e]] - centre);
  return s.mode_scale[c] * sum_over(lanes, sum);
}

/// The unit vector n that minimises n . X n / 2 - n . b, from a guess: Newton's method on the
/// sphere.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> best_direction(const Mat3T<Real>& x, const Vec3T<Real>& b,
                                                    Vec3T<Real> n) {
  constexpr int kIterations = 6;
  for (int i = 0; i < kIterations; ++i) {
    const Vec3T<Real> gradient = x * n - b;
    // H = P X P - (n . gradient) P, P = I - n n^T; the term along n keeps it regular.
    Mat3T<Real> p = outer(Real(-1) * n, n);
    for (int a = 0; a < 3; ++a) p(a, a) += Real(1);
    const Real trace = x(0, 0) + x(1, 1) + x(2, 2);
    Mat3T<Real> h = p * (x * p);
    h += (-dot(n, gradient)) * p;
    h += outer(trace * n, n);
    const Vec3T<Real> slope = p * gradient;
    Vec3T<Real> by = inverse(h) * slope;
    if (!(dot(by, slope) > Real(0))) by = slope / trace;
    n -= by;
    n = n / norm(n);
    if (norm_squared(by) < kEpsilon<Real> * kEpsilon<Real>) break;
  }
  return n;
}

/// Fits the axis n of a ring, which minimises sum k (n . (x - centre) - a . q)^2: the energy of its
/// stiffness along the vessel, so that no torque comes of it.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void fit_axis(const StepView<Real>& s, int c,
                                       const Mat3T<Real>& covariance, const Lanes& lanes) {
  if (!(s.cluster_along[c] > Real(0))) return;
  Mat3T<Real> spread;
  for (int e = s.cluster_begin[c] + lanes.rank(); e < s.cluster_begin[c + 1]; e += lanes.size()) {
    const Vec3T<Real> d = s.x[s.balloon_count + s.cluster_vertex[e]] - s.cluster_centre[c];
    spread += outer(s.cluster_stiffness[e] * d, d);
  }
  spread = sum_over_symmetric(lanes, spread);
  const Vec3T<Real> n = best_direction(spread, covariance * s.cluster_axis[c], s.cluster_normal[c]);
  lanes.sync();
  if (lanes.rank() == 0) s.cluster_normal[c] = n;
}

/// Fits a cluster's translation and rotation (Mueller 2005, section 3.3) and prepares its goals,
///
///     g = R (S^p q + sum_k N^p_k phi_k) + beta sum_k (B_k - R N^p_k) phi_k + centre
///
/// with B the coefficients of the modes in the best map. The fit is weighted by stiffness, so that
/// R minimises the energy. Mueller's beta (section 4.3) would act on the linear columns too: here
/// they stay, as they carry the pressure.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void fit_cluster(const StepView<Real>& s, int c, const Lanes& lanes) {
  Vec3T<Real> shift;  // of the centre from its start: small numbers, little rounding
  Real weight = 0;
  for (int e = s.cluster_begin[c] + lanes.rank(); e < s.cluster_begin[c + 1]; e += lanes.size()) {
    const int v = s.balloon_count + s.cluster_vertex[e];
    shift += s.cluster_stiffness[e] * (s.x[v] - s.start[v]);
    weight += s.cluster_stiffness[e];
  }
  const Vec3T<Real> centre = s.cluster_start[c] + sum_over(lanes, shift) / lanes.sum(weight);
  Mat3T<Real> covariance;
  for (int e = s.cluster_begin[c] + lanes.rank(); e < s.cluster_begin[c + 1]; e += lanes.size())
    covariance +=
        outer(s.cluster_stiffness[e] * (s.x[s.balloon_count + s.cluster_vertex[e]] - centre),
              plastic_offset(s, c, e));
  covariance = sum_over(lanes, covariance);
  const Mat3T<Real> rotation = nearest_rotation(covariance, s.cluster_rotation[c]);
  for (int k = 0; s.entry_modes && k < kShapeModes; ++k) {
    Vec3T<Real> mode = rotation * s.cluster_plastic_modes[c * kShapeModes + k];
    if (s.mode_freedom > Real(0))
      mode += s.mode_freedom * (best_mode(s, c, k, centre, lanes) - mode);
    if (lanes.rank() == 0) s.cluster_map_modes[c * kShapeModes + k] = mode;
  }
  lanes.sync();
  if (lanes.rank() == 0) {
    s.cluster_rotation[c] = rotation;
    s.cluster_map[c] = rotation * s.cluster_plastic[c];
    s.cluster_centre[c] = centre;
  }
  lanes.sync();
  fit_axis(s, c, covariance, lanes);
}

/// The stiffness-weighted mean of a wall vertex's goals, and what its rings ask along their axes.
template <class Real>
ANGIO_HOST_DEVICE inline void set_goal(const StepView<Real>& s, int i) {
  Vec3T<Real> sum;
  Real weight = 0;
  for (int n = s.entry_begin[i]; n < s.entry_begin[i + 1]; ++n) {
    const int e = s.entry[n], c = s.entry_cluster[e];
    Vec3T<Real> goal = s.cluster_map[c] * s.cluster_offset[e] + s.cluster_centre[c];
    if (s.entry_modes)
      for (int k = 0; k < kShapeModes; ++k)
        goal += s.entry_modes[e * kShapeModes + k] * s.cluster_map_modes[c * kShapeModes + k];
    sum += s.cluster_stiffness[e] * goal;
    weight += s.cluster_stiffness[e];
  }
  s.goal[i] = sum / weight;
  Mat3T<Real> stiffness;
  Vec3T<Real> force;
  for (int n = s.entry_begin[i]; n < s.entry_begin[i + 1]; ++n) {
    const int e = s.entry[n], c = s.entry_cluster[e];
    const Vec3T<Real> axis = s.cluster_normal[c];
    const Real k = s.cluster_along[c] * s.cluster_stiffness[e];
    const Real off = dot(axis, s.goal[i] - s.cluster_centre[c]) - s.entry_along[e];
    stiffness += outer(k * axis, axis);
    force -= k * off * axis;
  }
  s.along_stiffness[i] = stiffness;
  s.along_force[i] = force;
}

/// A cluster's elastic map: S = R^T A relative to its plastic shape, symmetric part, with A the
/// best linear map (Mueller 2005, Eq. 7), and R^T B - N^p of the modes. A flat cluster leaves A
/// open in the flat direction: there the rotation's own value (no strain) is taken, by a small
/// weight towards it.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline ShapeMap<Real> elastic_map(const StepView<Real>& s, int c,
                                                    const Lanes& lanes) {
  const Vec3T<Real> centre = s.cluster_centre[c];
  Mat3T<Real> pq, qq;
  for (int e = s.cluster_begin[c] + lanes.rank(); e < s.cluster_begin[c + 1]; e += lanes.size()) {
    const Vec3T<Real> q = s.cluster_plastic[c] * s.cluster_offset[e];
    pq += outer(s.cluster_stiffness[e] * (s.x[s.balloon_count + s.cluster_vertex[e]] - centre), q);
    qq += outer(s.cluster_stiffness[e] * q, q);
  }
  pq = sum_over(lanes, pq);
  qq = sum_over_symmetric(lanes, qq);
  const Real trace = qq(0, 0) + qq(1, 1) + qq(2, 2), scale = Real(1) / trace;
  const Real weight = Real(sizeof(Real) < 8 ? 1e-5 : 1e-9);
  pq = scale * pq + weight * s.cluster_rotation[c];
  qq = scale * qq;
  for (int i = 0; i < 3; ++i) qq(i, i) += weight;
  const Mat3T<Real> back = transpose(s.cluster_rotation[c]), a = back * (pq * inverse(qq));
  ShapeMap<Real> elastic;
  elastic.linear = Real(0.5) * (a + transpose(a));
  for (int k = 0; s.entry_modes && k < kShapeModes; ++k)
    elastic.modes[k] =
        back * best_mode(s, c, k, centre, lanes) - s.cluster_plastic_modes[c * kShapeModes + k];
  return elastic;
}

/// Lets a cluster, just fitted, flow for the time of the step.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void flow_cluster(const StepView<Real>& s, const PlasticFlow<Real>& law,
                                           int c, const Lanes& lanes) {
  ShapeMap<Real> plastic;
  plastic.linear = s.cluster_plastic[c];
  for (int k = 0; s.entry_modes && k < kShapeModes; ++k)
    plastic.modes[k] = s.cluster_plastic_modes[c * kShapeModes + k];
  plastic = flow(law, elastic_map(s, c, lanes), plastic, s.dt);
  lanes.sync();
  if (lanes.rank() == 0) {
    s.cluster_plastic[c] = plastic.linear;
    for (int k = 0; s.entry_modes && k < kShapeModes; ++k)
      s.cluster_plastic_modes[c * kShapeModes + k] = plastic.modes[k];
  }
  lanes.sync();
  for (int e = s.cluster_begin[c] + lanes.rank(); e < s.cluster_begin[c + 1]; e += lanes.size())
    s.entry_along[e] = dot(s.cluster_axis[c], plastic_offset(s, c, e));
}

}  // namespace angio::simulation::detail
