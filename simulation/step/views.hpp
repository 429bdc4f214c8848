#pragma once

#include "core/array_view.hpp"
#include "simulation/bodies/body_ranges.hpp"
#include "simulation/materials/membrane.hpp"
#include "simulation/materials/rod.hpp"
#include "simulation/materials/shape_matching.hpp"
#include "simulation/pbd/contact.hpp"
#include "simulation/pbd/gas.hpp"
#include "simulation/step/contact_pairs.hpp"
#include "simulation/step/solid_column.hpp"

/// A step's arrays as plain views, one for each concept. The inner loops on them are functions of
/// an index (near_pairs.hpp, sweep_*.hpp); program.hpp puts them into the step. Nothing there
/// allocates or knows of threads. Positions are relative to the scene's origin.
///
/// An array of constants (the model) is a view of const values; of the others `for_each_array` says
/// whether they are state, which lives from step to step, or work space of one step. It is the one
/// list of a view's arrays: what copies a view between memories goes through it. What drives a run
/// is StepRules and StepStatus::law (status.hpp).
namespace angio::simulation::detail {

enum class ArrayRole {
  model,  ///< constant
  state,  ///< lives from step to step
  work,   ///< no more than memory when a step begins
};

/// The other corners of one triangle seen from one of its corners, counter-clockwise.
struct CornerLink {
  int next = 0, last = 0;
};

/// The vertices of all bodies.
template <class Real>
struct MotionView {
  using Vec = Vec3T<Real>;

  int count = 0;  ///< with the copies of the wall further out
  Real dt = 0;    ///< [s]
  ArrayView<const Vec> start;
  ArrayView<const Real> mass;
  ArrayView<Vec> x;
  ArrayView<Vec> velocity;
  ArrayView<Vec> x_before;    ///< at the start of the step
  ArrayView<Vec> x_inertial;  ///< x_before + dt velocity
  ArrayView<Vec> x_searched;  ///< at the last search for near pairs
  ArrayView<Vec> x_swept;     ///< before the sweep
  ArrayView<Vec> swept_by;    ///< motion of the last sweep
  ArrayView<Real> area;       ///< of the two surfaces, at the start of the step [mm^2]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, start, mass);
    visit(ArrayRole::state, x, velocity);
    visit(ArrayRole::work, x_before, x_inertial, x_searched, x_swept, swept_by, area);
  }
};

/// A body's surface: its colours, and the triangles around each vertex.
struct MeshView {
  int first = 0;  ///< vertex
  int colors = 0;
  ArrayView<const int> color_begin;   ///< first vertex of a colour, [color + 1]
  ArrayView<const int> corner_begin;  ///< [vertex of the surface + 1]
  ArrayView<const CornerLink> corners;

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, color_begin, corner_begin, corners);
  }
};

/// What a balloon vertex is about to do within its colour.
template <class Real>
struct Move {
  Vec3T<Real> by_volume, by_force, by_pressure;  ///< g, w H^-1 f, w H^-1 g
  Real friction{};                               ///< |H^-1 f_friction| [mm]
  Real adhesion{};                               ///< |H^-1 f_adhesion| [mm]
  bool taut = true;
};

/// The balloon: a membrane around a gas.
template <class Real>
struct BalloonView {
  MeshView mesh;
  int triangle_count = 0;
  Real outside_pressure = 0;    ///< [Pa], absolute
  Real relaxation = Real(1.6);  ///< of vertices without contact
  bool has_folds = false;       ///< at the start
  MembraneLaw<Real> law;
  MooneyRivlin<Real> folds;
  ArrayView<const int> triangles;                  ///< three vertices each
  ArrayView<const CornerMetric<Real>> rest;        ///< [corner]
  ArrayView<const CornerMetric<Real>> start_rest;  ///< [corner], of the start shape: the folds
  ArrayView<Move<Real>> moves;                     ///< [balloon vertex]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    mesh.for_each_array(visit);
    visit(ArrayRole::model, triangles, rest, start_rest);
    visit(ArrayRole::work, moves);
  }
};

/// The wall's lumen, of either model.
template <class Real>
struct WallView {
  MeshView mesh;
  ArrayView<const Real> foundation;  ///< [wall vertex], at the wall's outer side
  ArrayView<Real> contact_pressure;  ///< [wall vertex]
  ArrayView<Vec3T<Real>> move;       ///< [wall vertex] not yet made, where the wall meets itself

  template <class Visit>
  void for_each_array(const Visit& visit) {
    mesh.for_each_array(visit);
    visit(ArrayRole::model, foundation);
    visit(ArrayRole::state, contact_pressure);
    visit(ArrayRole::work, move);
  }
};

/// What the wall's slabs are made of. The members of slab c are the slab vertices
/// begin[c] <= e < begin[c + 1].
template <class Real>
struct SlabShapeView {
  using Vec = Vec3T<Real>;

  ArrayView<const int> begin;
  ArrayView<const int> vertex;      ///< [slab vertex], of the wall
  ArrayView<const Real> stiffness;  ///< [slab vertex]
  ArrayView<const Vec> offset;      ///< [slab vertex]
  ArrayView<const Vec> start;       ///< centre at the start
  ArrayView<const Vec> axis;        ///< unit, along the vessel, at the start
  ArrayView<const Real> along;      ///< WallSlabs::along
  ArrayView<const Real> modes;  ///< phi [mm], [slab vertex][kShapeModes]; null: linear maps only
  ArrayView<const Real> mode_scale;  ///< 1 / sum k phi^2 [1/uN/mm], [slab]
  Real mode_freedom = 0;             ///< beta

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, begin, vertex, stiffness, offset, start, axis, along, modes,
          mode_scale);
  }
};

/// How the slabs lie now, and what has flowed. [slab]
template <class Real>
struct SlabFitView {
  using Vec = Vec3T<Real>;
  using Mat = Mat3T<Real>;

  ArrayView<Mat> rotation;
  ArrayView<Mat> plastic;
  ArrayView<Mat> map;            ///< rotation * plastic
  ArrayView<Vec> plastic_modes;  ///< [slab][kShapeModes]
  ArrayView<Vec> map_modes;      ///< rotation * plastic, and beta's share of the best fit
  ArrayView<Vec> centre;
  ArrayView<Vec> axis;          ///< now
  ArrayView<Real> place_along;  ///< [slab vertex] in the plastic shape, along the first axis [mm]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::state, rotation, plastic, map, plastic_modes, map_modes, axis, place_along);
    visit(ArrayRole::work, centre);
  }
};

/// What the slabs ask of the wall's vertices. The slab vertices of wall vertex i are
/// slab_vertex[begin[i]] to slab_vertex[begin[i + 1]].
template <class Real>
struct SlabGoalView {
  ArrayView<const int> begin;
  ArrayView<const int> slab_vertex;
  ArrayView<const int> slab;  ///< of a slab vertex
  ArrayView<const int> neighbor_begin;
  ArrayView<const int> neighbors;
  ArrayView<const Real> stiffness;         ///< [wall vertex]
  ArrayView<Vec3T<Real>> goal;             ///< [wall vertex]
  ArrayView<Mat3T<Real>> along_stiffness;  ///< [wall vertex] sum over its slabs, [uN/mm]
  ArrayView<Vec3T<Real>> along_force;      ///< of it, at the goal [uN]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, begin, slab_vertex, slab, neighbor_begin, neighbors, stiffness);
    visit(ArrayRole::work, goal, along_stiffness, along_force);
  }
};

/// The wall by shape matching.
template <class Real>
struct SlabsView {
  int count = 0;
  SlabShapeView<Real> shape;
  SlabFitView<Real> fit;
  SlabGoalView<Real> goals;

  template <class Visit>
  void for_each_array(const Visit& visit) {
    shape.for_each_array(visit);
    fit.for_each_array(visit);
    goals.for_each_array(visit);
  }
};

/// The wall as a layered solid: its vertex u is the step's vertex wall.first + u.
template <class Real>
struct LayeredWallView {
  SolidView<Real> solid;  ///< its positions and points are set by `link`
  SolidColumns<Real> columns;
  Real blood_pressure = 0;  ///< [Pa]
  int wedge_count = 0;
  ArrayView<SolidPoint<Real>> points;  ///< those of `solid`
  ArrayView<Real> plastic_strain;      ///< [point]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, solid.corners, solid.fibers, solid.region, solid.laws, solid.patch,
          solid.patch_begin, solid.patch_wedges, solid.patch_volume);
    visit(ArrayRole::model, columns.layer, columns.patch_begin, columns.patches);
    visit(ArrayRole::state, points, plastic_strain);
  }
  /// @param x  of the solid's vertices
  void link(const Vec3T<Real>* x) {
    solid.x = x;
    solid.points = points;
  }
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

/// The guidewire: `shape.count` vertices of the step from `first` on, moved all at once
/// (sweep_guidewire.hpp). Its own arithmetic is in double precision: it is far stiffer than the
/// balloon.
template <class Real>
struct GuidewireView {
  int first = 0;
  RodShape<double> shape;  ///< without nodes: no guidewire
  RodSection<double> section;
  ArrayView<const char> held;  ///< [node]
  ArrayView<const RodTie> ties;
  ArrayView<RodLoad<Real>> loads;  ///< [node, then tie]
  ArrayView<Vec3T<double>> x;      ///< [2][node]
  ArrayView<RodRow<double>> external;
  ArrayView<RodRow<double>> rows;  ///< `force` ends as the move of a node [mm]
  ArrayView<Real> share;           ///< [node, then tie]
  ArrayView<RodReport> report;

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, shape.rest, shape.bend, held, ties);
    visit(ArrayRole::work, loads, x, external, rows, share, report);
  }
};

/// Contact of the bodies with each other and themselves.
template <class Real>
struct ContactView {
  ContactLaw<Real> law;
  ArrayView<char> wet;  ///< [vertex of balloon or wall]: adhesion.hpp; null: no adhesion
  CandidateView<Real> candidates;
  NearPairView<Real> near;

  /// But for the arrays that a set of candidates comes with: their sizes change with it.
  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::state, wet);
    visit(ArrayRole::work, near.owned_end, near.ref_end, near.bound_end, near.moved, near.max_move);
  }
};

/// What the position-based reference method projects (pbd/).
template <class Real>
struct PbdView {
  PbdContact<Real> contact;
  PbdGas<Real> gas;

  [[nodiscard]] ANGIO_HOST_DEVICE bool is_on() const { return contact.is_on || gas.is_on; }

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, contact.color_begin, contact.tets, contact.balloon_corners,
          contact.inverse_mass);
    visit(ArrayRole::state, contact.triggered);
    visit(ArrayRole::model, gas.color_begin, gas.apex, gas.triangles, gas.inverse_mass, gas.volume);
  }
};

/// All that a step sees.
template <class Real>
struct StepView {
  BodyRanges bodies;
  MotionView<Real> motion;
  BalloonView<Real> balloon;
  WallView<Real> wall;
  SlabsView<Real> slabs;
  LayeredWallView<Real> layered;
  GuidewireView<Real> guidewire;
  ContactView<Real> contact;
  PbdView<Real> pbd;

  /// Calls visit(role, arrays...) until each array of a scene's size was in one call.
  template <class Visit>
  void for_each_array(const Visit& visit) {
    motion.for_each_array(visit);
    balloon.for_each_array(visit);
    wall.for_each_array(visit);
    slabs.for_each_array(visit);
    layered.for_each_array(visit);
    guidewire.for_each_array(visit);
    contact.for_each_array(visit);
    pbd.for_each_array(visit);
  }
  /// Sets what points into another view's array; after the arrays have come into another memory.
  void link() { layered.link(motion.x + bodies.wall().first); }
};

/// The surface of the body that a vertex belongs to, which is not the guidewire.
template <class Real>
ANGIO_HOST_DEVICE inline const MeshView& mesh_around(const StepView<Real>& s, int v) {
  return s.bodies.of(v) == Body::balloon ? s.balloon.mesh : s.wall.mesh;
}

/// What a frame hands out of a step's arrays, on a device or here (see State).
template <class Real>
struct StateView {
  ArrayView<Vec3T<Real>> x;
  ArrayView<Real> contact_pressure;
  ArrayView<Mat3T<Real>> plastic;        ///< [slab]
  ArrayView<Vec3T<Real>> plastic_modes;  ///< [slab][kShapeModes]
  ArrayView<SolidPoint<Real>> solid_points;
  ArrayView<Real> solid_plastic_strain;
};

template <class Real>
ANGIO_HOST_DEVICE inline StateView<Real> state_view(const StepView<Real>& s) {
  return {s.motion.x,
          s.wall.contact_pressure,
          {s.slabs.fit.plastic, s.slabs.count},
          {s.slabs.fit.plastic_modes, s.slabs.count > 0 ? s.slabs.fit.plastic_modes.count : 0},
          s.layered.points,
          s.layered.plastic_strain};
}

/// Calls visit(array, ...) with the same array of each of the views, one array after the other.
template <class Visit, class... Views>
ANGIO_HOST_DEVICE inline void for_each_state_array(const Visit& visit, Views&... views) {
  visit(views.x...);
  visit(views.contact_pressure...);
  visit(views.plastic...);
  visit(views.plastic_modes...);
  visit(views.solid_points...);
  visit(views.solid_plastic_strain...);
}

}  // namespace angio::simulation::detail
