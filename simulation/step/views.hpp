#pragma once

#include "simulation/bodies/body_ranges.hpp"
#include "simulation/materials/membrane.hpp"
#include "simulation/materials/rod.hpp"
#include "simulation/materials/shape_matching.hpp"
#include "simulation/pbd/view.hpp"
#include "simulation/step/array_role.hpp"
#include "simulation/step/contact_pairs.hpp"
#include "simulation/step/slide_view.hpp"
#include "simulation/step/solid_column.hpp"

/// A step's arrays as plain views, one for each concept. The inner loops on them are functions of
/// an index (near_pairs.hpp, sweep_*.hpp); program.hpp puts them into the step. Nothing there
/// allocates or knows of threads. Positions are relative to the scene's origin.
///
/// `for_each_array` is the one list of a view's arrays: what copies a view between memories goes
/// through it. It calls visit(role, count, arrays...); the role tells the model, which is constant,
/// from the state, which lives from step to step, and from the work space of one step. What drives
/// a run is Control (run/control.hpp): in a step StepRules and StepStatus::law (status.hpp).
namespace angio::simulation::detail {

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
  const Vec* start = nullptr;
  const Real* mass = nullptr;
  Vec* x = nullptr;
  Vec* velocity = nullptr;
  Vec* x_before = nullptr;    ///< at the start of the step
  Vec* x_inertial = nullptr;  ///< x_before + dt velocity
  Vec* x_searched = nullptr;  ///< at the last search for near pairs
  Vec* x_swept = nullptr;     ///< before the sweep
  Vec* swept_by = nullptr;    ///< motion of the last sweep
  Real* area = nullptr;       ///< of the two surfaces, at the start of the step [mm^2]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, count, start, mass);
    visit(ArrayRole::state, count, x, velocity);
    visit(ArrayRole::work, count, x_before, x_inertial, x_searched, x_swept, swept_by, area);
  }
};

/// A body's surface: its colours, and the triangles around each vertex.
struct MeshView {
  int first = 0, count = 0;  ///< vertices
  int colors = 0, corner_count = 0;
  const int* color_begin = nullptr;   ///< first vertex of a colour, [color + 1]
  const int* corner_begin = nullptr;  ///< [vertex of the surface + 1]
  const CornerLink* corners = nullptr;

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, colors + 1, color_begin);
    visit(ArrayRole::model, count + 1, corner_begin);
    visit(ArrayRole::model, corner_count, corners);
  }
};

/// What a balloon vertex is about to do within its colour.
template <class Real>
struct Move {
  Vec3T<Real> by_volume, by_force, by_pressure;  ///< g, w H^-1 f, w H^-1 g
  Real friction{};                               ///< |H^-1 f_friction| [mm]
  Real adhesion{};                               ///< |H^-1 f_adhesion| [mm]
  Real contact{};                                ///< sum of normal forces [uN]
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
  const int* triangles = nullptr;                  ///< three vertices each
  const CornerMetric<Real>* rest = nullptr;        ///< [corner]
  const CornerMetric<Real>* start_rest = nullptr;  ///< [corner], of the start shape: the folds
  Move<Real>* moves = nullptr;                     ///< [balloon vertex]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    mesh.for_each_array(visit);
    visit(ArrayRole::model, 3 * triangle_count, triangles);
    visit(ArrayRole::model, mesh.corner_count, rest, start_rest);
    visit(ArrayRole::work, mesh.count, moves);
  }
};

/// The wall's lumen, of either model.
template <class Real>
struct WallView {
  MeshView mesh;
  const Real* foundation = nullptr;  ///< [wall vertex], at the wall's outer side
  Real* contact_pressure = nullptr;  ///< [wall vertex]
  Vec3T<Real>* move = nullptr;       ///< [wall vertex] not yet made, where the wall meets itself

  template <class Visit>
  void for_each_array(const Visit& visit) {
    mesh.for_each_array(visit);
    visit(ArrayRole::model, mesh.count, foundation);
    visit(ArrayRole::state, mesh.count, contact_pressure);
    visit(ArrayRole::work, mesh.count, move);
  }
};

/// What the wall's slabs are made of. The members of slab c are the slab vertices
/// begin[c] <= e < begin[c + 1].
template <class Real>
struct SlabShapeView {
  using Vec = Vec3T<Real>;

  int count = 0, vertex_count = 0;  ///< slabs, and slab vertices
  const int* begin = nullptr;
  const int* vertex = nullptr;      ///< [slab vertex], of the wall
  const Real* stiffness = nullptr;  ///< [slab vertex]
  const Vec* offset = nullptr;      ///< [slab vertex]
  const Vec* start = nullptr;       ///< centre at the start
  const Vec* axis = nullptr;        ///< unit, along the vessel, at the start
  const Real* along = nullptr;      ///< WallSlabs::along
  const Real* modes = nullptr;  ///< phi [mm], [slab vertex][kShapeModes]; null: linear maps only
  const Real* mode_scale = nullptr;  ///< 1 / sum k phi^2 [1/uN/mm], [slab]
  Real mode_freedom = 0;             ///< beta

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, count + 1, begin);
    visit(ArrayRole::model, count, start, axis, along, mode_scale);
    visit(ArrayRole::model, vertex_count, vertex, stiffness, offset);
    visit(ArrayRole::model, vertex_count * kShapeModes, modes);
  }
};

/// How the slabs lie now, and what has flowed. [slab]
template <class Real>
struct SlabFitView {
  using Vec = Vec3T<Real>;
  using Mat = Mat3T<Real>;

  int count = 0, vertex_count = 0;  ///< slabs, and slab vertices
  Mat* rotation = nullptr;
  Mat* plastic = nullptr;
  Mat* map = nullptr;            ///< rotation * plastic
  Vec* plastic_modes = nullptr;  ///< [slab][kShapeModes]
  Vec* map_modes = nullptr;      ///< rotation * plastic, and beta's share of the best fit
  Vec* centre = nullptr;
  Vec* axis = nullptr;          ///< now
  Real* place_along = nullptr;  ///< [slab vertex] in the plastic shape, along the first axis [mm]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::state, count, rotation, plastic, map, axis);
    visit(ArrayRole::state, count * kShapeModes, plastic_modes, map_modes);
    visit(ArrayRole::state, vertex_count, place_along);
    visit(ArrayRole::work, count, centre);
  }
};

/// What the slabs ask of the wall's vertices. The slab vertices of wall vertex i are
/// slab_vertex[begin[i]] to slab_vertex[begin[i + 1]].
template <class Real>
struct SlabGoalView {
  int count = 0;  ///< wall vertices
  int slab_vertex_count = 0, neighbor_count = 0;
  const int* begin = nullptr;
  const int* slab_vertex = nullptr;
  const int* slab = nullptr;  ///< of a slab vertex
  const int* neighbor_begin = nullptr;
  const int* neighbors = nullptr;
  const Real* stiffness = nullptr;         ///< [wall vertex]
  Vec3T<Real>* goal = nullptr;             ///< [wall vertex]
  Mat3T<Real>* along_stiffness = nullptr;  ///< [wall vertex] sum over its slabs, [uN/mm]
  Vec3T<Real>* along_force = nullptr;      ///< of it, at the goal [uN]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, count + 1, begin, neighbor_begin);
    visit(ArrayRole::model, count, stiffness);
    visit(ArrayRole::model, slab_vertex_count, slab_vertex, slab);
    visit(ArrayRole::model, neighbor_count, neighbors);
    visit(ArrayRole::work, count, goal, along_stiffness, along_force);
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
  SolidColumns columns;
  ColumnRows<Real> rows;
  Real blood_pressure = 0;  ///< [Pa]
  int wedge_count = 0, patch_count = 0, region_count = 0;
  int column_patch_count = 0, column_wedge_count = 0, link_count = 0;  ///< of all columns
  SolidPoint<Real>* points = nullptr;                                  ///< those of `solid`
  Real* plastic_strain = nullptr;                                      ///< [point]
  const char* led = nullptr;  ///< [column] does it go with its neighbours?

  [[nodiscard]] ANGIO_HOST_DEVICE int point_count() const { return kWedgePoints * wedge_count; }

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, 6 * wedge_count, solid.corners);
    visit(ArrayRole::model, 2 * wedge_count, solid.fibers);
    visit(ArrayRole::model, wedge_count, solid.region, solid.patch, solid.patch_wedges,
          columns.layer);
    visit(ArrayRole::model, region_count, solid.laws);
    visit(ArrayRole::model, patch_count + 1, solid.patch_begin);
    visit(ArrayRole::model, patch_count, solid.patch_volume, solid.patch_bulk);
    visit(ArrayRole::model, columns.stride + 1, columns.patch_begin, columns.wedge_begin,
          columns.link_begin);
    visit(ArrayRole::state, columns.stride, rows.steepness);
    visit(ArrayRole::model, columns.stride, led);
    visit(ArrayRole::model, column_patch_count, columns.patches);
    visit(ArrayRole::model, column_wedge_count, columns.wedges);
    visit(ArrayRole::model, link_count, columns.links);
    visit(ArrayRole::state, point_count(), points, plastic_strain);
    visit(ArrayRole::state, wedge_count, rows.places, rows.tangents, rows.forces);
    visit(ArrayRole::work, wedge_count, rows.renewed, rows.wedge_volume);
    visit(ArrayRole::work, patch_count, rows.patch_volume);
    visit(ArrayRole::state, columns.stride * columns.levels, rows.constant, rows.pivot, rows.upper,
          rows.above);
    visit(ArrayRole::state, link_count * columns.levels * 3, rows.beside);
    visit(ArrayRole::state, column_patch_count, rows.by_low, rows.by_high);
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

/// What a step reports to the team of its rod.
struct RodReport {
  double net = 0.0, load = 0.0;  ///< squared [uN^2]
  double share = 1.0;            ///< of the moves that the bounds let it take
  double withheld = 0.0;         ///< of them by the bounds, squared [mm^2]
};

/// The guidewire: `shape.count` vertices of the step from `first` on, moved all at once
/// (sweep_guidewire.hpp). Its own arithmetic is in double precision: it is far stiffer than the
/// balloon.
template <class Real>
struct GuidewireView {
  int first = 0;
  RodShape<double> shape;  ///< without nodes: no guidewire
  RodSection<double> section;
  int tie_count = 0;
  const char* held = nullptr;  ///< [node]
  const RodTie* ties = nullptr;
  RodLoad<Real>* loads = nullptr;  ///< [node, then tie]
  Vec3T<double>* x = nullptr;      ///< [2][node]
  RodRow<double>* external = nullptr;
  RodRow<double>* rows = nullptr;  ///< `force` ends as the move of a node [mm]
  Real* share = nullptr;           ///< [node, then tie]
  RodReport* report = nullptr;

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, shape.count - 1, shape.rest);
    visit(ArrayRole::model, shape.count, shape.bend, held);
    visit(ArrayRole::model, tie_count, ties);
    visit(ArrayRole::work, shape.count + tie_count, loads, share);
    visit(ArrayRole::work, 2 * shape.count, x);
    visit(ArrayRole::work, shape.count, external, rows);
    visit(ArrayRole::work, 1, report);
  }
};

/// Contact of the bodies with each other and themselves.
template <class Real>
struct ContactView {
  int vertex_count = 0;
  ContactLaw<Real> law;
  char* wet = nullptr;  ///< [vertex of balloon or wall]: adhesion.hpp; null: no adhesion
  CandidateView<Real> candidates;
  NearPairView<Real> near;

  /// But for the arrays that a set of candidates comes with: their sizes change with it.
  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::state, vertex_count, wet);
    visit(ArrayRole::work, vertex_count, near.owned_end, near.ref_end, near.bound_end, near.moved,
          near.max_move);
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
  SlideView<Real> slide;
  ContactView<Real> contact;
  PbdView<Real> pbd;

  /// Lists all arrays but those that a set of candidates comes with.
  template <class Visit>
  void for_each_array(const Visit& visit) {
    motion.for_each_array(visit);
    balloon.for_each_array(visit);
    wall.for_each_array(visit);
    slabs.for_each_array(visit);
    layered.for_each_array(visit);
    guidewire.for_each_array(visit);
    slide.for_each_array(visit);
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

}  // namespace angio::simulation::detail
