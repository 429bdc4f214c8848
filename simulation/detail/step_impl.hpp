#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "simulation/detail/contact_force.hpp"
#include "simulation/detail/contact_set.hpp"
#include "simulation/detail/scene.hpp"
#include "simulation/detail/shape_matching.hpp"

/// One step's inner loops as functions of an index over plain views: step_cpu.cpp loops over them.
/// Nothing here allocates or knows of threads.
namespace angio::simulation::detail {

/// A smoothing spring's share of its vertices' wall stiffness: the wall bends rather than being
/// pierced by a single vertex. A tube of 16 edges around gets 2 % stiffer by it.
inline constexpr double kWallSmoothing = 0.1;

/// Pointers into the scene and the state of a step; see there for units and shapes.
struct StepView {
  int balloon_count = 0;
  double dt = 0.0;
  double outside_pressure = 0.0;   // [Pa], absolute
  double contact_distance = 0.0;   // [mm]
  double contact_stiffness = 0.0;  // [Pa/mm]
  double relaxation = 1.6;         // of vertices without contact
  Friction<double> friction;
  MooneyRivlin<double> skin, folds;
  bool relaxed = false;
  // Scene
  const Vec3* start = nullptr;
  const double* mass = nullptr;
  const int* corner_begin = nullptr;
  const Corner* corners = nullptr;
  const int* cluster_begin = nullptr;
  const int* cluster_vertex = nullptr;
  const double* cluster_stiffness = nullptr;
  const Vec3* cluster_offset = nullptr;
  const int* entry_begin = nullptr;
  const int* entry = nullptr;
  const int* entry_cluster = nullptr;
  const int* neighbor_begin = nullptr;
  const int* neighbors = nullptr;
  const double* foundation = nullptr;
  // State
  Vec3* x = nullptr;                 // [vertex]
  const Vec3* x_before = nullptr;    // at the start of the step
  const Vec3* x_inertial = nullptr;  // x_before + dt velocity
  const Vec3* x_detected = nullptr;  // at the last contact detection
  Mat3* cluster_rotation = nullptr;  // [cluster]
  const Mat3* cluster_plastic = nullptr;
  Mat3* cluster_map = nullptr;  // rotation * plastic
  Vec3* cluster_centre = nullptr;
  Vec3* goal = nullptr;                    // [wall vertex]
  const double* goal_stiffness = nullptr;  // [wall vertex]
  ContactPair* pairs = nullptr;
  double* pair_weights = nullptr;  // area, faded out for parallel edges; 0: out of contact
  const int* ref_begin = nullptr;
  const ContactRef* refs = nullptr;
  const int* bound_begin = nullptr;
  const MotionBound* bounds = nullptr;
  double travel = 0.0;
};

/// What a vertex's neighbours ask of it.
struct VertexForces {
  Vec3 force;              // without the gas [uN]
  Mat3 hessian;            // [uN/mm]
  Vec3 friction;           // the part of `force` that is friction
  double contact = 0.0;    // sum of normal forces [uN]
  double magnitude = 0.0;  // sum of the lengths of the forces [uN]
  bool touching = false;
  bool taut = true;  // the skin all around
};

/// Recomputes a pair's closest points and weight at the present positions.
ANGIO_HOST_DEVICE inline void refresh_pair(const StepView& s, int index) {
  ContactPair& pair = s.pairs[index];
  const Vec3 p[4] = {s.x[pair.vertex[0]], s.x[pair.vertex[1]], s.x[pair.vertex[2]],
                     s.x[pair.vertex[3]]};
  pair.weights = pair.edges ? segment_segment_gap(p[0], p[1], p[2], p[3])
                            : point_triangle_gap(p[0], p[1], p[2], p[3]);
  Vec3 gap;
  for (int i = 0; i < 4; ++i) gap += pair.weights.w[i] * p[i];
  const double d = norm(gap);
  pair.direction = d > 0.0 ? gap / d : pair.normal;
  // A pair just out of contact is kept ready for the motion of one sweep.
  const bool near = d < 1.5 * s.contact_distance;
  const double fade = pair.edges ? sine_squared(p[1] - p[0], p[3] - p[2]) : 1.0;
  s.pair_weights[index] = near ? pair.area * fade : 0.0;
}

/// Adds the barrier and the friction of all pairs of a vertex.
///
/// Within a sweep a gap is taken along its last direction with its last weights, d = n . sum w_i
/// x_i (exact to first order); refresh_pair renews both before each sweep.
ANGIO_HOST_DEVICE inline void add_contact(const StepView& s, int v, VertexForces& out) {
  for (int r = s.ref_begin[v]; r < s.ref_begin[v + 1]; ++r) {
    const double weight = s.pair_weights[s.refs[r].pair];
    if (!(weight > 0.0)) continue;
    const ContactPair& pair = s.pairs[s.refs[r].pair];
    const double w = pair.weights.w[s.refs[r].corner];
    if (w == 0.0) continue;
    Vec3 gap, gap_before;
    for (int i = 0; i < 4; ++i) gap += pair.weights.w[i] * s.x[pair.vertex[i]];
    const Vec3 n = pair.direction;
    const double least = 0.05 * s.contact_distance;
    double d = dot(n, gap);
    if (d >= s.contact_distance) continue;
    d = d > least ? d : (norm(gap) < least ? norm(gap) : least);
    const Barrier<double> b = barrier(d, s.contact_distance);
    const double scale = s.contact_stiffness * weight;
    const double normal_force = -scale * b.slope;
    out.touching = true;
    out.contact += normal_force * std::abs(w);
    out.force += (normal_force * w) * n;
    out.magnitude += normal_force * std::abs(w);
    const double stiffness = scale * b.curvature * w * w;
    for (int i = 0; i < 4; ++i) gap_before += pair.weights.w[i] * s.x_before[pair.vertex[i]];
    Vec3 slip = gap - gap_before;
    slip -= dot(slip, n) * n;
    const double rub = normal_force * friction_per_slip(s.friction, norm(slip));
    const Vec3 friction = (-rub * w) * slip;
    out.force += friction;
    out.friction += friction;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        out.hessian(i, j) +=
            stiffness * n[i] * n[j] + rub * w * w * ((i == j ? 1.0 : 0.0) - n[i] * n[j]);
  }
}

ANGIO_HOST_DEVICE inline void add_inertia(const StepView& s, int v, VertexForces& out) {
  const double k = s.mass[v] / (s.dt * s.dt);
  out.force += k * (s.x_inertial[v] - s.x[v]);
  for (int i = 0; i < 3; ++i) out.hessian(i, i) += k;
}

ANGIO_HOST_DEVICE inline EnergyDensity<double> skin_energy(const StepView& s, const Corner& corner,
                                                           const Vec3& e1, const Vec3& e2) {
  const Invariants<double> i = invariants(corner.rest, e1, e2);
  return s.relaxed ? relaxed_energy(s.skin, i.i1, i.i3) : plain_energy(s.skin, i.i1, i.i3);
}

ANGIO_HOST_DEVICE inline EnergyDensity<double> fold_energy(const StepView& s, const Corner& corner,
                                                           const Vec3& e1, const Vec3& e2) {
  const Invariants<double> i = invariants(corner.start, e1, e2);
  return plain_energy(s.folds, i.i1, i.i3);
}

/// Skin, folds and gas on a vertex of the balloon, for the line search.
ANGIO_HOST_DEVICE inline Vec3 skin_and_gas_force(const StepView& s, int v, const Vec3& x,
                                                 double gauge) {
  Vec3 force;
  for (int c = s.corner_begin[v]; c < s.corner_begin[v + 1]; ++c) {
    const Corner& corner = s.corners[c];
    const Vec3 e1 = x - s.x[corner.next], e2 = s.x[corner.last] - s.x[corner.next];
    force -= membrane_gradient(corner.rest, skin_energy(s, corner, e1, e2), e1, e2);
    force -= membrane_gradient(corner.start, fold_energy(s, corner, e1, e2), e1, e2);
    force += (gauge / 6.0) * cross(s.x[corner.next], s.x[corner.last]);
  }
  return force;
}

/// Everything but the gas on a vertex of the balloon, and dV/dx of the enclosed volume [mm^2].
ANGIO_HOST_DEVICE inline VertexForces balloon_forces(const StepView& s, int v, Vec3& by_volume) {
  VertexForces out;
  by_volume = {};
  for (int c = s.corner_begin[v]; c < s.corner_begin[v + 1]; ++c) {
    const Corner& corner = s.corners[c];
    const Vec3 e1 = s.x[v] - s.x[corner.next], e2 = s.x[corner.last] - s.x[corner.next];
    const EnergyDensity<double> psi = skin_energy(s, corner, e1, e2);
    const VertexTerm<double> term = membrane_term(corner.rest, psi, e1, e2);
    out.force -= term.gradient;
    out.hessian += term.hessian;
    out.taut = out.taut && psi.taut;
    if (s.relaxed) {
      const EnergyDensity<double> fold = fold_energy(s, corner, e1, e2);
      if (psi.taut) {  // a thousandth of the skin's stiffness need not be in the Hessian
        out.force -= membrane_gradient(corner.start, fold, e1, e2);
      } else {
        const VertexTerm<double> fold_term = membrane_term(corner.start, fold, e1, e2);
        out.force -= fold_term.gradient;
        out.hessian += fold_term.hessian;
      }
    }
    by_volume += (1.0 / 6.0) * cross(s.x[corner.next], s.x[corner.last]);
  }
  add_contact(s, v, out);
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
ANGIO_HOST_DEVICE inline double balloon_line_search(const StepView& s, int v, double gauge,
                                                    const Vec3& move) {
  double share = 1.0;
  const double before = -dot(skin_and_gas_force(s, v, s.x[v], gauge), move);
  if (!(before < 0.0)) return share;
  for (int trial = 0; trial < 3; ++trial) {
    const double after = -dot(skin_and_gas_force(s, v, s.x[v] + share * move, gauge), move);
    if (after <= -before) break;
    share *= before / (before - after);
  }
  return share;
}

/// Everything on a vertex of the wall.
ANGIO_HOST_DEVICE inline VertexForces wall_forces(const StepView& s, int v) {
  VertexForces out;
  const int i = v - s.balloon_count;
  const Vec3 off = s.x[v] - s.goal[i];
  double k = s.goal_stiffness[i];
  const Vec3 elastic = -k * off;
  out.force += elastic;
  out.magnitude += norm(elastic);
  for (int n = s.neighbor_begin[i]; n < s.neighbor_begin[i + 1]; ++n) {
    const int u = s.neighbors[n];
    const double spring =
        0.5 * kWallSmoothing * (s.goal_stiffness[i] + s.goal_stiffness[u - s.balloon_count]);
    out.force -= spring * (off - (s.x[u] - s.goal[u - s.balloon_count]));
    k += spring;
  }
  out.force += s.foundation[i] * (s.start[v] - s.x[v]);
  k += s.foundation[i];
  for (int a = 0; a < 3; ++a) out.hessian(a, a) += k;
  add_contact(s, v, out);
  add_inertia(s, v, out);
  return out;
}

/// H^-1 b of a symmetric positive definite 3 x 3 block.
ANGIO_HOST_DEVICE inline Mat3 inverse_block(Mat3 h) {
  const double trace = h(0, 0) + h(1, 1) + h(2, 2);
  for (int i = 0; i < 3; ++i) h(i, i) += 1e-9 * trace;
  return inverse(h);
}

/// The longest part of a move that keeps the vertex within its bounds since the last detection.
/// @return share in [0, 1]
ANGIO_HOST_DEVICE inline double allowed_share(const StepView& s, int v, const Vec3& move) {
  const Vec3 done = s.x[v] - s.x_detected[v];
  double share = 1.0;
  for (int b = s.bound_begin[v]; b < s.bound_begin[v + 1]; ++b) {
    const MotionBound& bound = s.bounds[b];
    const double more = -dot(bound.normal, move);
    if (!(more > 0.0)) continue;
    const double left = bound.limit + dot(bound.normal, done);
    if (more > left) {
      const double part = left > 0.0 ? left / more : 0.0;
      share = part < share ? part : share;
    }
  }
  // |done + t move| <= travel
  const double a = dot(move, move), b = dot(done, move), c = dot(done, done) - s.travel * s.travel;
  if (a + 2.0 * b + c > 0.0) {
    const double root = b * b - a * c;
    double part = root > 0.0 && a > 0.0 ? (-b + std::sqrt(root)) / a : 0.0;
    part = part > 0.0 ? part : 0.0;
    share = part < share ? part : share;
  }
  return share;
}

/// Fits a cluster's translation and rotation (Mueller 2005, section 3.3) and prepares its goals,
/// g = R S^p q + centre. The fit is weighted by stiffness, so that R minimises the energy.
ANGIO_HOST_DEVICE inline void fit_cluster(const StepView& s, int c) {
  Vec3 centre;
  double weight = 0.0;
  for (int e = s.cluster_begin[c]; e < s.cluster_begin[c + 1]; ++e) {
    centre += s.cluster_stiffness[e] * s.x[s.balloon_count + s.cluster_vertex[e]];
    weight += s.cluster_stiffness[e];
  }
  centre = centre / weight;
  Mat3 covariance;
  for (int e = s.cluster_begin[c]; e < s.cluster_begin[c + 1]; ++e)
    covariance +=
        outer(s.cluster_stiffness[e] * (s.x[s.balloon_count + s.cluster_vertex[e]] - centre),
              s.cluster_plastic[c] * s.cluster_offset[e]);
  s.cluster_rotation[c] = nearest_rotation(covariance, s.cluster_rotation[c]);
  s.cluster_map[c] = s.cluster_rotation[c] * s.cluster_plastic[c];
  s.cluster_centre[c] = centre;
}

/// The stiffness-weighted mean of a wall vertex's goals.
ANGIO_HOST_DEVICE inline void set_goal(const StepView& s, int i) {
  Vec3 sum;
  double weight = 0.0;
  for (int n = s.entry_begin[i]; n < s.entry_begin[i + 1]; ++n) {
    const int e = s.entry[n], c = s.entry_cluster[e];
    sum += s.cluster_stiffness[e] * (s.cluster_map[c] * s.cluster_offset[e] + s.cluster_centre[c]);
    weight += s.cluster_stiffness[e];
  }
  s.goal[i] = sum / weight;
}

/// A cluster's stretch S = R^T A relative to its plastic shape, symmetric part, with A the best
/// linear map (Mueller 2005, Eq. 7). A flat cluster leaves A open in the flat direction: there the
/// rotation's own value (no strain) is taken, by a small weight towards it.
ANGIO_HOST_DEVICE inline Mat3 cluster_stretch(const StepView& s, int c) {
  Mat3 pq, qq;
  for (int e = s.cluster_begin[c]; e < s.cluster_begin[c + 1]; ++e) {
    const Vec3 q = s.cluster_plastic[c] * s.cluster_offset[e];
    pq += outer(
        s.cluster_stiffness[e] * (s.x[s.balloon_count + s.cluster_vertex[e]] - s.cluster_centre[c]),
        q);
    qq += outer(s.cluster_stiffness[e] * q, q);
  }
  const double weight = 1e-6 * (qq(0, 0) + qq(1, 1) + qq(2, 2));
  pq += weight * s.cluster_rotation[c];
  for (int i = 0; i < 3; ++i) qq(i, i) += weight;
  const Mat3 a = transpose(s.cluster_rotation[c]) * (pq * inverse(qq));
  return 0.5 * (a + transpose(a));
}

}  // namespace angio::simulation::detail
