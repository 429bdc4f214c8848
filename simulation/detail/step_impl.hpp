#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "simulation/detail/contact_force.hpp"
#include "simulation/detail/distance.hpp"
#include "simulation/detail/membrane.hpp"
#include "simulation/detail/shape_matching.hpp"
#include "simulation/detail/solid_column.hpp"

/// One step's inner loops as functions of an index over plain views; step_program.hpp puts them
/// into the step. Nothing here allocates or knows of threads. `lanes` are the threads that share
/// the index (launch.hpp).
namespace angio::simulation::detail {

/// A smoothing spring's share of its vertices' wall stiffness: the wall bends rather than being
/// pierced by a single vertex. A tube of 16 edges around gets 2 % stiffer by it.
inline constexpr double kWallSmoothing = 0.1;

/// The other corners of one triangle seen from one of its corners, counter-clockwise.
struct CornerLink {
  int next = 0, last = 0;
};

/// A vertex of one surface near a triangle of the other, or an edge near an edge.
template <class Real>
struct NearPair {
  int vertex[4]{};  ///< vertex, triangle; or balloon edge, wall edge
  bool edges = false;
  Real area{};         ///< that it stands for [mm^2]
  Vec3T<Real> normal;  ///< at detection: unit, from side b to side a
  // Below: at the last refresh.
  GapWeights<Real> weights;
  Vec3T<Real> direction;  ///< unit gap direction
  Real weight{};          ///< area, faded out for parallel edges; 0: out of contact
};

struct ContactRef {
  int pair = 0, corner = 0;
};

/// A plane that a vertex may not pass until the next detection: n . (x - x_detected) >= -limit.
template <class Real>
struct MotionBound {
  Vec3T<Real> normal;
  Real limit{};  ///< [mm], >= 0
};

/// What a balloon vertex is about to do within its colour.
template <class Real>
struct Move {
  Vec3T<Real> by_volume, by_force, by_pressure;  ///< g, w H^-1 f, w H^-1 g
  Real friction{};                               ///< |H^-1 f_friction| [mm]
  bool taut = true;
};

/// Pointers into the scene and the state of a step; see there for units and shapes. Positions are
/// relative to the scene's origin.
template <class Real>
struct StepView {
  using Vec = Vec3T<Real>;
  using Mat = Mat3T<Real>;

  int balloon_count = 0, wall_count = 0, cluster_count = 0, pair_count = 0, triangle_count = 0;
  int vertex_count = 0;  // with the copies of the wall further out
  int balloon_colors = 0, wall_colors = 0;
  Real dt = 0;
  Real outside_pressure = 0;    // [Pa], absolute
  Real contact_distance = 0;    // [mm]
  Real contact_stiffness = 0;   // [Pa/mm]
  Real relaxation = Real(1.6);  // of vertices without contact
  Friction<Real> friction;
  SkinLaw<Real> skin;
  MooneyRivlin<Real> folds;
  // Scene
  const int* balloon_color_begin = nullptr;  // first vertex of a color
  const int* wall_color_begin = nullptr;
  const int* triangles = nullptr;  // of the balloon, three vertices each
  const Vec* start = nullptr;
  const Real* mass = nullptr;
  const int* corner_begin = nullptr;
  const CornerLink* corners = nullptr;
  const CornerMetric<Real>* rest = nullptr;        // [corner]
  const CornerMetric<Real>* start_rest = nullptr;  // [corner], of the start shape: the folds
  const int* cluster_begin = nullptr;
  const int* cluster_vertex = nullptr;
  const Real* cluster_stiffness = nullptr;
  const Vec* cluster_offset = nullptr;
  const Vec* cluster_start = nullptr;  // centre at the start
  const Real* entry_modes = nullptr;   // phi [mm], [entry][kShapeModes]; null: linear maps only
  const Real* mode_scale = nullptr;    // 1 / sum k phi^2 [1/uN/mm], [cluster]
  Real mode_freedom = 0;               // beta
  const int* entry_begin = nullptr;
  const int* entry = nullptr;
  const int* entry_cluster = nullptr;
  const int* neighbor_begin = nullptr;
  const int* neighbors = nullptr;
  const Real* foundation = nullptr;
  const Real* goal_stiffness = nullptr;  // [wall vertex]
  // Layered wall: solid vertex u is the step's vertex balloon_count + u
  SolidView<Real> solid;
  SolidColumns<Real> columns;
  const int* lumen_begin = nullptr;           // lumen triangles around a column
  const CornerLink* lumen_corners = nullptr;  // columns
  Real blood_pressure = 0;                    // [Pa]
  int wedge_count = 0;
  SolidPoint<Real>* solid_points = nullptr;  // those of `solid`
  Real* solid_plastic_strain = nullptr;      // [point]
  // State
  Vec* x = nullptr;  // [vertex]
  Vec* velocity = nullptr;
  Vec* x_before = nullptr;          // at the start of the step
  Vec* x_inertial = nullptr;        // x_before + dt velocity
  const Vec* x_detected = nullptr;  // at the last contact detection
  Move<Real>* moves = nullptr;      // [balloon vertex]
  Real* contact_force = nullptr;    // [wall vertex]
  Mat* cluster_rotation = nullptr;  // [cluster]
  Mat* cluster_plastic = nullptr;
  Mat* cluster_map = nullptr;            // rotation * plastic
  Vec* cluster_plastic_modes = nullptr;  // [cluster][kShapeModes]
  Vec* cluster_map_modes = nullptr;      // rotation * plastic, and beta's share of the best fit
  Vec* cluster_centre = nullptr;
  Vec* goal = nullptr;  // [wall vertex]
  NearPair<Real>* pairs = nullptr;
  const int* ref_begin = nullptr;
  const ContactRef* refs = nullptr;
  const int* bound_begin = nullptr;
  const MotionBound<Real>* bounds = nullptr;
  Real travel = 0;
};

/// What a vertex's neighbours ask of it.
template <class Real>
struct VertexForces {
  Vec3T<Real> force;     // without the gas [uN]
  Mat3T<Real> hessian;   // [uN/mm]
  Vec3T<Real> friction;  // the part of `force` that is friction
  Real contact{};        // sum of normal forces [uN]
  Real magnitude{};      // sum of the lengths of the forces [uN]
  bool touching = false;
  bool taut = true;  // the skin all around
};

template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> sum_over(const Lanes& lanes, const Vec3T<Real>& v) {
  return {lanes.sum(v.x), lanes.sum(v.y), lanes.sum(v.z)};
}

template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Mat3T<Real> sum_over_symmetric(const Lanes& lanes, const Mat3T<Real>& a) {
  Mat3T<Real> b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) b(i, j) = b(j, i) = lanes.sum(a(i, j));
  return b;
}

template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Mat3T<Real> sum_over(const Lanes& lanes, const Mat3T<Real>& a) {
  Mat3T<Real> b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) b(i, j) = lanes.sum(a(i, j));
  return b;
}

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
  // A pair just out of contact is kept ready for the motion of one sweep.
  const bool near = d < Real(1.5) * s.contact_distance;
  const Real fade = pair.edges ? sine_squared(p[1] - p[0], p[3] - p[2]) : Real(1);
  pair.weight = near ? pair.area * fade : Real(0);
}

/// Adds the barrier and the friction of a vertex's pairs, each lane its share of them.
///
/// Within a sweep a gap is taken along its last direction with its last weights, d = n . sum w_i
/// x_i (exact to first order); refresh_pair renews both before each sweep.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void add_contact(const StepView<Real>& s, int v, const Lanes& lanes,
                                          VertexForces<Real>& out) {
  for (int r = s.ref_begin[v] + lanes.rank(); r < s.ref_begin[v + 1]; r += lanes.size()) {
    const NearPair<Real>& pair = s.pairs[s.refs[r].pair];
    const Real w = pair.weights.w[s.refs[r].corner];
    if (!(pair.weight > Real(0)) || w == Real(0)) continue;
    const Vec3T<Real> n = pair.direction, base = s.x[pair.vertex[0]];
    Vec3T<Real> gap;
    for (int i = 1; i < 4; ++i) gap += pair.weights.w[i] * (s.x[pair.vertex[i]] - base);
    const Real least = Real(0.05) * s.contact_distance;
    Real d = dot(n, gap);
    if (d >= s.contact_distance) continue;
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

template <class Real>
ANGIO_HOST_DEVICE inline void add_inertia(const StepView<Real>& s, int v, VertexForces<Real>& out) {
  const Real k = s.mass[v] / (s.dt * s.dt);
  out.force += k * (s.x_inertial[v] - s.x[v]);
  for (int i = 0; i < 3; ++i) out.hessian(i, i) += k;
}

/// Adds what the lanes have gathered. Only force and Hessian where nothing can touch.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void gather(const StepView<Real>& s, const Lanes& lanes,
                                     VertexForces<Real>& out) {
  out.force = sum_over(lanes, out.force);
  out.hessian = sum_over_symmetric(lanes, out.hessian);
  out.taut = lanes.sum(out.taut ? 0 : 1) == 0;
  if (s.pair_count == 0) return;
  out.friction = sum_over(lanes, out.friction);
  out.contact = lanes.sum(out.contact);
  out.magnitude = lanes.sum(out.magnitude);
  out.touching = lanes.sum(out.touching ? 1 : 0) > 0;
}

template <class Real>
ANGIO_HOST_DEVICE inline EnergyDensity<Real> fold_energy(const StepView<Real>& s,
                                                         const CornerMetric<Real>& start,
                                                         const Vec3T<Real>& e1,
                                                         const Vec3T<Real>& e2) {
  const Invariants<Real> i = invariants(start, e1, e2);
  return plain_energy(s.folds, i.i1, i.i3);
}

/// Skin, folds and gas on a vertex of the balloon, for the line search.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> skin_and_gas_force(const StepView<Real>& s, int v,
                                                        const Lanes& lanes, const Vec3T<Real>& x,
                                                        Real gauge) {
  Vec3T<Real> force;
  for (int c = s.corner_begin[v] + lanes.rank(); c < s.corner_begin[v + 1]; c += lanes.size()) {
    const Vec3T<Real> next = s.x[s.corners[c].next], last = s.x[s.corners[c].last];
    const Vec3T<Real> e1 = x - next, e2 = last - next;
    force -= membrane_gradient(s.rest[c], skin_energy(s.skin, s.rest[c], e1, e2), e1, e2);
    if (s.skin.relaxed)
      force -= membrane_gradient(s.start_rest[c], fold_energy(s, s.start_rest[c], e1, e2), e1, e2);
    force += (gauge / Real(6)) * cross(e2, e1);
  }
  return sum_over(lanes, force);
}

/// Everything but the gas on a vertex of the balloon, and dV/dx of the enclosed volume [mm^2].
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline VertexForces<Real> balloon_forces(const StepView<Real>& s, int v,
                                                           const Lanes& lanes,
                                                           Vec3T<Real>& by_volume) {
  VertexForces<Real> out;
  by_volume = {};
  const Vec3T<Real> x = s.x[v];
  for (int c = s.corner_begin[v] + lanes.rank(); c < s.corner_begin[v + 1]; c += lanes.size()) {
    const Vec3T<Real> next = s.x[s.corners[c].next], last = s.x[s.corners[c].last];
    const Vec3T<Real> e1 = x - next, e2 = last - next;
    const EnergyDensity<Real> psi = skin_energy(s.skin, s.rest[c], e1, e2);
    const VertexTerm<Real> term = membrane_term(s.rest[c], psi, e1, e2);
    out.force -= term.gradient;
    out.hessian += term.hessian;
    out.taut = out.taut && psi.taut;
    if (s.skin.relaxed) {
      const EnergyDensity<Real> fold = fold_energy(s, s.start_rest[c], e1, e2);
      if (psi.taut) {  // a thousandth of the skin's stiffness need not be in the Hessian
        out.force -= membrane_gradient(s.start_rest[c], fold, e1, e2);
      } else {
        const VertexTerm<Real> fold_term = membrane_term(s.start_rest[c], fold, e1, e2);
        out.force -= fold_term.gradient;
        out.hessian += fold_term.hessian;
      }
    }
    // The ring of edges around the vertex is closed: any origin gives the same sum, and the vertex
    // itself the one with the least rounding.
    by_volume += (Real(1) / Real(6)) * cross(e2, e1);
  }
  if (s.pair_count > 0) add_contact(s, v, lanes, out);
  gather(s, lanes, out);
  by_volume = sum_over(lanes, by_volume);
  add_inertia(s, v, out);
  return out;
}

/// The share of a balloon vertex's move to be taken, in (0, 1]: a slack skin that goes taut within
/// the move meets it with a far greater stiffness than the Hessian it began with.
///
/// If the energy's slope along the move, positive at its end, outweighs that at its start, the
/// share is where the chord of the slope is zero. The slope is convex there, so the energy still
/// falls.
///
/// @param gauge  pressure above the outside [Pa]
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Real balloon_line_search(const StepView<Real>& s, int v,
                                                  const Lanes& lanes, Real gauge,
                                                  const Vec3T<Real>& move) {
  Real share = Real(1);
  const Real before = -dot(skin_and_gas_force(s, v, lanes, s.x[v], gauge), move);
  if (!(before < Real(0))) return share;
  for (int trial = 0; trial < 3; ++trial) {
    const Real after = -dot(skin_and_gas_force(s, v, lanes, s.x[v] + share * move, gauge), move);
    if (after <= -before) break;
    share *= before / (before - after);
  }
  return share;
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
  if (s.pair_count > 0) add_contact(s, v, lanes, out);
  gather(s, lanes, out);
  const Vec3T<Real> elastic = -s.goal_stiffness[i] * off;
  out.force += elastic;
  out.magnitude += norm(elastic);
  out.force += s.foundation[i] * (s.start[v] - s.x[v]);
  for (int a = 0; a < 3; ++a) out.hessian(a, a) += s.goal_stiffness[i] + s.foundation[i];
  add_inertia(s, v, out);
  return out;
}

/// H^-1 b of a symmetric positive definite 3 x 3 block.
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> inverse_block(Mat3T<Real> h) {
  const Real trace = h(0, 0) + h(1, 1) + h(2, 2);
  const Real scale = trace > Real(0) ? Real(1) / trace : Real(0);  // no overflow in the determinant
  h = scale * h;
  for (int i = 0; i < 3; ++i) h(i, i) += Real(sizeof(Real) < 8 ? 1e-6 : 1e-9);
  return scale * inverse(h);
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
  const Mat3T<Real> rotation = nearest_rotation(sum_over(lanes, covariance), s.cluster_rotation[c]);
  for (int k = 0; s.entry_modes && k < kShapeModes; ++k) {
    Vec3T<Real> mode = rotation * s.cluster_plastic_modes[c * kShapeModes + k];
    if (s.mode_freedom > Real(0))
      mode += s.mode_freedom * (best_mode(s, c, k, centre, lanes) - mode);
    if (lanes.rank() == 0) s.cluster_map_modes[c * kShapeModes + k] = mode;
  }
  lanes.sync();
  if (lanes.rank() > 0) return;
  s.cluster_rotation[c] = rotation;
  s.cluster_map[c] = rotation * s.cluster_plastic[c];
  s.cluster_centre[c] = centre;
}

/// The stiffness-weighted mean of a wall vertex's goals.
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
  if (lanes.rank() > 0) return;
  s.cluster_plastic[c] = plastic.linear;
  for (int k = 0; s.entry_modes && k < kShapeModes; ++k)
    s.cluster_plastic_modes[c * kShapeModes + k] = plastic.modes[k];
}

}  // namespace angio::simulation::detail
