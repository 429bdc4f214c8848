#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "simulation/contact/adhesion.hpp"
#include "simulation/contact/contact_force.hpp"
#include "simulation/contact/distance.hpp"
#include "simulation/materials/membrane.hpp"
#include "simulation/materials/rod.hpp"
#include "simulation/materials/shape_matching.hpp"
#include "simulation/materials/symmetric3.hpp"
#include "simulation/pbd/contact.hpp"
#include "simulation/pbd/gas.hpp"
#include "simulation/step/solid_column.hpp"

/// A step's arrays as plain views. The inner loops on them, in step_contact.hpp, step_balloon.hpp
/// and step_wall.hpp, are functions of an index; step_program.hpp puts them into the step. Nothing
/// there allocates or knows of threads. `lanes` are the threads that share the index (launch.hpp).
namespace angio::simulation::detail {

template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<double> in_double(const Vec3T<Real>& v) {
  return {double(v.x), double(v.y), double(v.z)};
}

/// The other corners of one triangle seen from one of its corners, counter-clockwise.
struct CornerLink {
  int next = 0, last = 0;
};

/// A vertex and a triangle, or two edges, that face each other and may come near. A triangle whose
/// last two corners are one vertex is a segment of the guidewire.
struct Candidate {
  int vertex[4]{};  ///< vertex, triangle; or edge, edge
  bool edges = false;
  bool inner = false;  ///< of the balloon and the shaft inside it
  bool skin = false;   ///< of the balloon and itself, or the wall and itself
  float radius = 0;    ///< of the shaft there [mm]: it is taken off the gap
  float distance = 0;  ///< skin: contact acts below this gap [mm]
  float gap = 0;       ///< where it was found, less the radius; at most that [mm]
};

/// A candidate that is near, and since when. What is read of one that does nothing comes first.
template <class Real>
struct NearPair {
  int vertex[4]{};                                  ///< as in Candidate
  bool edges = false, inner = false, skin = false;  ///< as in Candidate
  Real distance{};                                  ///< contact acts below this gap [mm]
  Real radius{};                                    ///< as in Candidate
  // At the last refresh:
  Real weight{};  ///< area, faded out for parallel edges; 0: out of contact
  Real film{};    ///< area of the film that holds vertex and triangle together [mm^2]
  GapWeights<Real> weights;
  Vec3T<Real> direction;   ///< unit gap direction
  Vec3T<Real> gap_before;  ///< sum w_i x_i at the start of the step
  Real gap{};              ///< less the radius; or, where nothing can act, a bound of it [mm]
  // At the search:
  Real gap_searched{};  ///< less the radius [mm]
  Real area{};          ///< that it stands for [mm^2]
  Vec3T<Real> normal;   ///< unit, from side b to side a
  Real limit[4]{};      ///< how far each vertex may go against its side of the normal [mm]
  /// Of the other side, the corner that moves at the same time, by its colour; -1: none.
  short twin[4] = {-1, -1, -1, -1};
};

/// A vertex's place in a candidate or a pair.
struct ContactRef {
  int pair = 0, corner = 0;
};

/// A plane that a vertex may not pass until the next search: n . (x - x_searched) >= -limit.
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
  Real adhesion{};                               ///< |H^-1 f_adhesion| [mm]
  bool taut = true;
};

/// A vertex of the balloon that is tied to the shaft, between the rod's nodes `node` and the next:
/// it moves by (1 - share) and share of theirs.
struct RodTie {
  int vertex = 0, node = 0;
  double share = 0.0;
};

/// What acts on a rod's node or on a tied vertex, apart from the rod itself.
template <class Real>
struct RodLoad {
  Vec3T<Real> force;      ///< [uN]
  Mat3T<Real> hessian;    ///< [uN/mm]
  Vec3T<Real> by_volume;  ///< of a tied vertex [mm^2]
  Real magnitude{};       ///< [uN]
};

/// What a step tells the team of its rod.
struct RodReport {
  double net = 0.0, load = 0.0;  ///< squared [uN^2]
  double share = 1.0;            ///< of the moves that the bounds let it take
};

/// The guidewire: vertices `first` to `first + shape.count` of the step, moved all at once
/// (step_rod.hpp). Its own arithmetic is in double precision: it is far stiffer than the balloon.
template <class Real>
struct RodView {
  int first = 0;
  RodShape<double> shape;  ///< without nodes: no guidewire
  RodSection<double> section;
  const char* held = nullptr;  ///< [node]
  int tie_count = 0;
  const RodTie* ties = nullptr;
  // Work space of a sweep
  RodLoad<Real>* loads = nullptr;  ///< [node, then tie]
  Vec3T<double>* x = nullptr;      ///< [2][node]
  RodRow<double>* external = nullptr;
  RodRow<double>* rows = nullptr;  ///< `force` ends as the move of a node [mm]
  Real* share = nullptr;           ///< [node, then tie]
  RodReport* report = nullptr;
};

/// Pointers into the scene and the state of a step; see there for units and shapes. Positions are
/// relative to the scene's origin.
template <class Real>
struct StepView {
  using Vec = Vec3T<Real>;
  using Mat = Mat3T<Real>;

  int balloon_count = 0, wall_count = 0, cluster_count = 0, triangle_count = 0;
  int candidate_count = 0;
  int vertex_count = 0;  // with the copies of the wall further out
  int balloon_colors = 0, wall_colors = 0;
  Real dt = 0;
  Real outside_pressure = 0;    // [Pa], absolute
  Real contact_distance = 0;    // [mm]
  Real contact_range = 0;       // gap beyond which nothing acts [mm]
  Real self_distance = 0;       // of a surface with itself [mm]; 0: not looked for
  bool has_folds = false;       // of the balloon, at the start
  Real contact_stiffness = 0;   // [Pa/mm]
  Real relaxation = Real(1.6);  // of vertices without contact
  Friction<Real> friction;
  Adhesion<Real> adhesion;
  PaperContact<Real> paper;
  PaperGas<Real> paper_gas;
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
  const Vec* cluster_start = nullptr;   // centre at the start
  const Vec* cluster_axis = nullptr;    // unit, along the vessel, at the start
  const Real* cluster_along = nullptr;  // WallClusters::along
  const Real* entry_modes = nullptr;    // phi [mm], [entry][kShapeModes]; null: linear maps only
  const Real* mode_scale = nullptr;     // 1 / sum k phi^2 [1/uN/mm], [cluster]
  Real mode_freedom = 0;                // beta
  Real* entry_along = nullptr;          // of its place in the plastic shape, along the axis [mm]
  const int* entry_begin = nullptr;
  const int* entry = nullptr;
  const int* entry_cluster = nullptr;
  const int* neighbor_begin = nullptr;
  const int* neighbors = nullptr;
  const Real* foundation = nullptr;
  const Real* goal_stiffness = nullptr;    // [wall vertex]
  const int* wall_corner_begin = nullptr;  // triangles around a wall vertex
  const CornerLink* wall_corners = nullptr;
  // Layered wall: solid vertex u is the step's vertex balloon_count + u
  SolidView<Real> solid;
  SolidColumns<Real> columns;
  Real blood_pressure = 0;  // [Pa]
  int wedge_count = 0;
  SolidPoint<Real>* solid_points = nullptr;  // those of `solid`
  Real* solid_plastic_strain = nullptr;      // [point]
  RodView<Real> rod;
  // State
  Vec* x = nullptr;  // [vertex]
  Vec* velocity = nullptr;
  Vec* x_before = nullptr;           // at the start of the step
  Vec* x_inertial = nullptr;         // x_before + dt velocity
  Vec* x_searched = nullptr;         // at the last search for near pairs
  Vec* x_swept = nullptr;            // before the sweep
  Vec* swept_by = nullptr;           // motion of the last sweep
  Vec* wall_move = nullptr;          // [wall vertex] not yet made, where the wall meets itself
  Move<Real>* moves = nullptr;       // [balloon vertex]
  Real* contact_pressure = nullptr;  // [wall vertex]
  Mat* cluster_rotation = nullptr;   // [cluster]
  Mat* cluster_plastic = nullptr;
  Mat* cluster_map = nullptr;            // rotation * plastic
  Vec* cluster_plastic_modes = nullptr;  // [cluster][kShapeModes]
  Vec* cluster_map_modes = nullptr;      // rotation * plastic, and beta's share of the best fit
  Vec* cluster_centre = nullptr;
  Vec* cluster_normal = nullptr;   // its axis now
  Vec* goal = nullptr;             // [wall vertex]
  Mat* along_stiffness = nullptr;  // [wall vertex] sum over its slabs, [uN/mm]
  Vec* along_force = nullptr;      // of it, at the goal [uN]
  char* wet = nullptr;             // [vertex of balloon or wall]: adhesion.hpp; null: no adhesion
  Real* area = nullptr;            // [vertex] of the two surfaces, at the start of the step [mm^2]
  // Candidates, owned by their first vertex and in its order; from the host now and then
  const Candidate* candidates = nullptr;
  const int* owned_begin = nullptr;  // [vertex + 1] first candidate
  const int* ref_begin = nullptr;    // [vertex + 1] candidates, or near pairs, that it is in
  const ContactRef* candidate_refs = nullptr;
  const Vec* x_candidates = nullptr;  // positions when they were found
  Real* gone = nullptr;               // [vertex] since then, or since the last search [mm]
  Real* travel = nullptr;             // [vertex] how far it may go until the next search [mm]
  Real candidate_reach = 0;           // pairs nearer than this were candidates then [mm]
  Real skin_reach = 0;                // the same of a surface with itself
  // Near pairs, each owner's and each vertex's from where its candidates begin
  NearPair<Real>* pairs = nullptr;
  int* owned_end = nullptr;
  int* pair_of = nullptr;  // of a candidate; -1: not near; null: not asked for
  ContactRef* refs = nullptr;
  int* listed_begin = nullptr;  // `ref_begin`, where one thread lists the pairs; [vertex + 1]
  int* ref_end = nullptr;
  MotionBound<Real>* bounds = nullptr;
  int* bound_end = nullptr;
};

/// What a vertex's neighbours ask of it.
template <class Real>
struct VertexForces {
  Vec3T<Real> force;     // without the gas [uN]
  Mat3T<Real> hessian;   // [uN/mm]
  Vec3T<Real> friction;  // the part of `force` that is friction
  Vec3T<Real> adhesion;  // the part of `force` that is adhesion
  Vec3T<Real> own;   // the part of `force` that is a surface's contact with itself; not gathered
  Real contact{};    // sum of normal forces [uN]
  Real magnitude{};  // sum of the lengths of the forces [uN]
  bool touching = false;
  bool touching_wall = false;
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
  if (s.candidate_count == 0) return;
  out.friction = sum_over(lanes, out.friction);
  if (s.wet) out.adhesion = sum_over(lanes, out.adhesion);
  out.contact = lanes.sum(out.contact);
  out.magnitude = lanes.sum(out.magnitude);
  out.touching = lanes.sum(out.touching ? 1 : 0) > 0;
}

}  // namespace angio::simulation::detail
