#pragma once

#include "simulation/step/sweep_sums.hpp"

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
  if (s.contact.law.self_distance > Real(0))
    s.wall.move[v - s.bodies.wall().first] = by;
  else
    s.motion.x[v] += by;
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void make_wall_moves(Team& team, const StepView<Real>& s, int first,
                                              int count) {
  if (!(s.contact.law.self_distance > Real(0))) return;
  team.template for_each<1>(count, [&](int i, const auto&) {
    s.motion.x[first + i] += s.wall.move[first + i - s.bodies.wall().first];
  });
  team.barrier();
}

/// Everything on a vertex of the wall.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline VertexForces<Real> wall_forces(const StepView<Real>& s, int v,
                                                        const Lanes& lanes) {
  VertexForces<Real> out;
  const int i = v - s.bodies.wall().first;
  const Vec3T<Real> off = s.motion.x[v] - s.slabs.goals.goal[i];
  Real k = 0;
  for (int n = s.slabs.goals.neighbor_begin[i] + lanes.rank();
       n < s.slabs.goals.neighbor_begin[i + 1]; n += lanes.size()) {
    const int u = s.slabs.goals.neighbors[n], j = u - s.bodies.wall().first;
    const Real spring =
        Real(0.5 * kWallSmoothing) * (s.slabs.goals.stiffness[i] + s.slabs.goals.stiffness[j]);
    out.force -= spring * (off - (s.motion.x[u] - s.slabs.goals.goal[j]));
    k += spring;
  }
  for (int a = 0; a < 3; ++a) out.hessian(a, a) = k;
  if (s.contact.candidates.count > 0) add_contact(s, v, lanes, out);
  gather(s, lanes, out);
  const Vec3T<Real> elastic = s.slabs.goals.along_force[i] -
                              s.slabs.goals.along_stiffness[i] * off -
                              s.slabs.goals.stiffness[i] * off;
  out.force += elastic;
  out.magnitude += norm(elastic);
  out.force += s.wall.foundation[i] * (s.motion.start[v] - s.motion.x[v]);
  out.hessian += s.slabs.goals.along_stiffness[i];
  for (int a = 0; a < 3; ++a)
    out.hessian(a, a) += s.slabs.goals.stiffness[i] + s.wall.foundation[i];
  add_inertia(s, v, out);
  return out;
}

/// Where a slab vertex is.
template <class Real>
ANGIO_HOST_DEVICE inline const Vec3T<Real>& slab_point(const StepView<Real>& s, int e) {
  return s.motion.x[s.bodies.wall().first + s.slabs.shape.vertex[e]];
}

/// A member's place in the plastic shape of its slab.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> plastic_offset(const StepView<Real>& s, int c, int e) {
  Vec3T<Real> q = s.slabs.fit.plastic[c] * s.slabs.shape.offset[e];
  if (s.slabs.shape.modes)
    for (int k = 0; k < kShapeModes; ++k)
      q +=
          s.slabs.shape.modes[e * kShapeModes + k] * s.slabs.fit.plastic_modes[c * kShapeModes + k];
  return q;
}

/// The coefficient of a mode in the slab's best map.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> best_mode(const StepView<Real>& s, int c, int k,
                                               const Vec3T<Real>& centre, const Lanes& lanes) {
  Vec3T<Real> sum;
  for (int e = s.slabs.shape.begin[c] + lanes.rank(); e < s.slabs.shape.begin[c + 1];
       e += lanes.size())
    sum += (s.slabs.shape.stiffness[e] * s.slabs.shape.modes[e * kShapeModes + k]) *
           (slab_point(s, e) - centre);
  return s.slabs.shape.mode_scale[c] * sum_over(lanes, sum);
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
  if (!(s.slabs.shape.along[c] > Real(0))) return;
  Mat3T<Real> spread;
  for (int e = s.slabs.shape.begin[c] + lanes.rank(); e < s.slabs.shape.begin[c + 1];
       e += lanes.size()) {
    const Vec3T<Real> d = slab_point(s, e) - s.slabs.fit.centre[c];
    spread += outer(s.slabs.shape.stiffness[e] * d, d);
  }
  spread = sum_over_symmetric(lanes, spread);
  const Vec3T<Real> n =
      best_direction(spread, covariance * s.slabs.shape.axis[c], s.slabs.fit.axis[c]);
  lanes.sync();
  if (lanes.rank() == 0) s.slabs.fit.axis[c] = n;
}

/// Fits a slab's translation and rotation (Mueller 2005, section 3.3) and prepares its goals,
///
///     g = R (S^p q + sum_k N^p_k phi_k) + beta sum_k (B_k - R N^p_k) phi_k + centre
///
/// with B the coefficients of the modes in the best map. The fit is weighted by stiffness, so that
/// R minimises the energy. Mueller's beta (section 4.3) would act on the linear columns too: here
/// they stay, as they carry the pressure.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void fit_slab(const StepView<Real>& s, int c, const Lanes& lanes) {
  Vec3T<Real> shift;  // of the centre from its start: small numbers, little rounding
  Real weight = 0;
  for (int e = s.slabs.shape.begin[c] + lanes.rank(); e < s.slabs.shape.begin[c + 1];
       e += lanes.size()) {
    const int v = s.bodies.wall().first + s.slabs.shape.vertex[e];
    shift += s.slabs.shape.stiffness[e] * (s.motion.x[v] - s.motion.start[v]);
    weight += s.slabs.shape.stiffness[e];
  }
  const Vec3T<Real> centre = s.slabs.shape.start[c] + sum_over(lanes, shift) / lanes.sum(weight);
  Mat3T<Real> covariance;
  for (int e = s.slabs.shape.begin[c] + lanes.rank(); e < s.slabs.shape.begin[c + 1];
       e += lanes.size())
    covariance +=
        outer(s.slabs.shape.stiffness[e] * (slab_point(s, e) - centre), plastic_offset(s, c, e));
  covariance = sum_over(lanes, covariance);
  const Mat3T<Real> rotation = nearest_rotation(covariance, s.slabs.fit.rotation[c]);
  for (int k = 0; s.slabs.shape.modes && k < kShapeModes; ++k) {
    Vec3T<Real> mode = rotation * s.slabs.fit.plastic_modes[c * kShapeModes + k];
    if (s.slabs.shape.mode_freedom > Real(0))
      mode += s.slabs.shape.mode_freedom * (best_mode(s, c, k, centre, lanes) - mode);
    if (lanes.rank() == 0) s.slabs.fit.map_modes[c * kShapeModes + k] = mode;
  }
  lanes.sync();
  if (lanes.rank() == 0) {
    s.slabs.fit.rotation[c] = rotation;
    s.slabs.fit.map[c] = rotation * s.slabs.fit.plastic[c];
    s.slabs.fit.centre[c] = centre;
  }
  lanes.sync();
  fit_axis(s, c, covariance, lanes);
}

/// The stiffness-weighted mean of a wall vertex's goals, and what its rings ask along their axes.
template <class Real>
ANGIO_HOST_DEVICE inline void set_goal(const StepView<Real>& s, int i) {
  const SlabShapeView<Real>& shape = s.slabs.shape;
  const SlabFitView<Real>& fit = s.slabs.fit;
  const SlabGoalView<Real>& goals = s.slabs.goals;
  Vec3T<Real> sum;
  Real weight = 0;
  for (int n = goals.begin[i]; n < goals.begin[i + 1]; ++n) {
    const int e = goals.slab_vertex[n], c = goals.slab[e];
    Vec3T<Real> goal = fit.map[c] * shape.offset[e] + fit.centre[c];
    if (shape.modes)
      for (int k = 0; k < kShapeModes; ++k)
        goal += shape.modes[e * kShapeModes + k] * fit.map_modes[c * kShapeModes + k];
    sum += shape.stiffness[e] * goal;
    weight += shape.stiffness[e];
  }
  goals.goal[i] = sum / weight;
  Mat3T<Real> stiffness;
  Vec3T<Real> force;
  for (int n = goals.begin[i]; n < goals.begin[i + 1]; ++n) {
    const int e = goals.slab_vertex[n], c = goals.slab[e];
    const Vec3T<Real> axis = fit.axis[c];
    const Real k = shape.along[c] * shape.stiffness[e];
    const Real off = dot(axis, goals.goal[i] - fit.centre[c]) - fit.place_along[e];
    stiffness += outer(k * axis, axis);
    force -= k * off * axis;
  }
  goals.along_stiffness[i] = stiffness;
  goals.along_force[i] = force;
}

/// A slab's elastic map: S = R^T A relative to its plastic shape, symmetric part, with A the
/// best linear map (Mueller 2005, Eq. 7), and R^T B - N^p of the modes. A flat slab leaves A
/// open in the flat direction: there the rotation's own value (no strain) is taken, by a small
/// weight towards it.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline ShapeMap<Real> elastic_map(const StepView<Real>& s, int c,
                                                    const Lanes& lanes) {
  const Vec3T<Real> centre = s.slabs.fit.centre[c];
  Mat3T<Real> pq, qq;
  for (int e = s.slabs.shape.begin[c] + lanes.rank(); e < s.slabs.shape.begin[c + 1];
       e += lanes.size()) {
    const Vec3T<Real> q = s.slabs.fit.plastic[c] * s.slabs.shape.offset[e];
    pq += outer(s.slabs.shape.stiffness[e] * (slab_point(s, e) - centre), q);
    qq += outer(s.slabs.shape.stiffness[e] * q, q);
  }
  pq = sum_over(lanes, pq);
  qq = sum_over_symmetric(lanes, qq);
  const Real trace = qq(0, 0) + qq(1, 1) + qq(2, 2), scale = Real(1) / trace;
  const Real weight = Real(sizeof(Real) < 8 ? 1e-5 : 1e-9);
  pq = scale * pq + weight * s.slabs.fit.rotation[c];
  qq = scale * qq;
  for (int i = 0; i < 3; ++i) qq(i, i) += weight;
  const Mat3T<Real> back = transpose(s.slabs.fit.rotation[c]), a = back * (pq * inverse(qq));
  ShapeMap<Real> elastic;
  elastic.linear = Real(0.5) * (a + transpose(a));
  for (int k = 0; s.slabs.shape.modes && k < kShapeModes; ++k)
    elastic.modes[k] =
        back * best_mode(s, c, k, centre, lanes) - s.slabs.fit.plastic_modes[c * kShapeModes + k];
  return elastic;
}

/// Lets a slab, just fitted, flow for the time of the step.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void flow_slab(const StepView<Real>& s, const PlasticFlow<Real>& law,
                                        int c, const Lanes& lanes) {
  ShapeMap<Real> plastic;
  plastic.linear = s.slabs.fit.plastic[c];
  for (int k = 0; s.slabs.shape.modes && k < kShapeModes; ++k)
    plastic.modes[k] = s.slabs.fit.plastic_modes[c * kShapeModes + k];
  plastic = flow(law, elastic_map(s, c, lanes), plastic, s.motion.dt);
  lanes.sync();
  if (lanes.rank() == 0) {
    s.slabs.fit.plastic[c] = plastic.linear;
    for (int k = 0; s.slabs.shape.modes && k < kShapeModes; ++k)
      s.slabs.fit.plastic_modes[c * kShapeModes + k] = plastic.modes[k];
  }
  lanes.sync();
  for (int e = s.slabs.shape.begin[c] + lanes.rank(); e < s.slabs.shape.begin[c + 1];
       e += lanes.size())
    s.slabs.fit.place_along[e] = dot(s.slabs.shape.axis[c], plastic_offset(s, c, e));
}

/// Moves the wall's vertices of a colour; total: squared net force and load, and what
/// contact has withheld.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void move_wall_vertices(Team& team, const StepView<Real>& s, int first,
                                                 int count, double (&total)[3]) {
  team.template quick_sum<Team::kVertexLanes, 3>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const int v = first + i;
        const VertexForces<Real> f = wall_forces(s, v, lanes);
        const Real net = norm_squared(f.force);
        part[0] += net;
        part[1] += f.magnitude * f.magnitude;
        Vec3T<Real> move;
        if (net > Real(0)) move = inverse_block(f.hessian) * f.force;
        const Real share = bounded_share<Team>(s, v, move);
        part[2] += norm_squared((Real(1) - share) * move);
        lanes.sync();
        if (lanes.rank() == 0) move_wall_vertex(s, v, share * move);
      },
      total);
}

}  // namespace angio::simulation::detail
