#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "core/units.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/contact/candidates.hpp"

/// From a scene in double precision to the arrays of a step, in a backend's memory.
namespace angio::simulation::detail {

template <class Real>
CornerMetric<Real> converted(const CornerMetric<double>& k) {
  return {Real(k.k11),    Real(k.k12), Real(k.k22), Real(k.inverse_det),
          Real(k.volume), Real(k.f1),  Real(k.f2)};
}

template <class Real>
MooneyRivlin<Real> converted(const MooneyRivlin<double>& m) {
  return {Real(m.c1), Real(m.c2)};
}

template <class Real>
SkinLaw<Real> converted(const SkinLaw<double>& law) {
  SkinLaw<Real> result;
  result.base = converted<Real>(law.base);
  result.relaxed = law.relaxed;
  result.fibre.count = law.fibre.count;
  for (int i = 0; i < law.fibre.count; ++i) {
    result.fibre.i4[i] = Real(law.fibre.i4[i]);
    result.fibre.value[i] = Real(law.fibre.value[i]);
    result.fibre.slope[i] = Real(law.fibre.slope[i]);
    result.fibre.curvature[i] = Real(law.fibre.curvature[i]);
  }
  return result;
}

template <class To, class From>
Vec3T<To> converted(const Vec3T<From>& v) {
  return {To(v.x), To(v.y), To(v.z)};
}

template <class To, class From>
Mat3T<To> converted(const Mat3T<From>& a) {
  Mat3T<To> b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) b(i, j) = To(a(i, j));
  return b;
}

template <class Real, class Value>
auto converted_all(const std::vector<Value>& values) {
  std::vector<decltype(converted<Real>(values[0]))> result;
  result.reserve(values.size());
  for (const Value& value : values) result.push_back(converted<Real>(value));
  return result;
}

template <class Real>
std::vector<Real> converted_all(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

/// Keeps a step's arrays in the computer's own memory.
class HostMemory {
 public:
  template <class Value>
  Value* store(std::vector<Value> values) {
    auto block = std::make_shared<std::vector<Value>>(std::move(values));
    blocks_.push_back(block);
    return block->data();
  }
  template <class Value>
  Value* allocate(std::size_t count) {
    return store(std::vector<Value>(count));
  }

 private:
  std::vector<std::shared_ptr<void>> blocks_;
};

/// Positions relative to the scene's origin: single precision needs small numbers.
template <class Real>
std::vector<Vec3T<Real>> local(const Scene& scene, const std::vector<Vec3>& x) {
  std::vector<Vec3T<Real>> result;
  result.reserve(x.size());
  for (const Vec3& p : x) result.push_back(converted<Real>(p - scene.origin));
  return result;
}

/// Back to patient space: the start in double precision and how far a vertex has gone from it.
template <class Real>
std::vector<Vec3> global(const Scene& scene, const Vec3T<Real>* start, const Vec3T<Real>* x) {
  std::vector<Vec3> result(scene.start.size());
  for (std::size_t v = 0; v < result.size(); ++v)
    result[v] = scene.start[v] + (converted<double>(x[v]) - converted<double>(start[v]));
  return result;
}

inline std::vector<int> flattened(const std::vector<Triangle>& triangles) {
  std::vector<int> result;
  for (const Triangle& t : triangles) result.insert(result.end(), t.begin(), t.end());
  return result;
}

template <class Real, class Memory>
void add_balloon_view(const Scene& scene, Memory& memory, StepView<Real>& view) {
  view.balloon_count = scene.balloon_count;
  view.triangle_count = int(scene.balloon_triangles.size());
  view.balloon_colors = int(scene.balloon_color_begin.size()) - 1;
  view.balloon_color_begin = memory.store(scene.balloon_color_begin);
  view.triangles = memory.store(flattened(scene.balloon_triangles));
  view.corner_begin = memory.store(scene.corner_begin);
  std::vector<CornerLink> links;
  std::vector<CornerMetric<Real>> rest, start;
  for (const Corner& corner : scene.corners) {
    links.push_back({corner.next, corner.last});
    rest.push_back(converted<Real>(corner.rest));
    if (scene.skin.relaxed) start.push_back(converted<Real>(corner.start));
  }
  view.corners = memory.store(links);
  view.rest = memory.store(rest);
  view.start_rest = memory.store(start);
  view.skin = converted<Real>(scene.skin);
  view.folds = converted<Real>(scene.folds);
  view.moves = memory.template allocate<Move<Real>>(std::size_t(scene.balloon_count));
}

/// The triangles around each vertex of the wall.
template <class Real, class Memory>
void add_wall_corners(const Scene& scene, Memory& memory, StepView<Real>& view) {
  std::vector<std::vector<CornerLink>> corners(std::size_t(scene.wall_count));
  for (const Triangle& t : scene.wall_triangles)
    for (std::size_t k = 0; k < 3; ++k)
      corners[std::size_t(t[k] - scene.balloon_count)].push_back({t[(k + 1) % 3], t[(k + 2) % 3]});
  std::vector<CornerLink> links;
  std::vector<int> corner_begin{0};
  for (const std::vector<CornerLink>& list : corners) {
    links.insert(links.end(), list.begin(), list.end());
    corner_begin.push_back(int(links.size()));
  }
  view.wall_corner_begin = memory.store(corner_begin);
  view.wall_corners = memory.store(links);
}

/// Of each cluster's members along its axis [mm], shape [entry].
inline std::vector<double> places_along(const WallClusters& clusters) {
  std::vector<double> along;
  for (std::size_t c = 0; c < std::size_t(clusters.count()); ++c)
    for (int e = clusters.begin[c]; e < clusters.begin[c + 1]; ++e)
      along.push_back(dot(clusters.axis[c], clusters.offset[std::size_t(e)]));
  return along;
}

template <class Real, class Memory>
void add_wall_view(const Scene& scene, const WallMaterial& wall, Memory& memory,
                   StepView<Real>& view) {
  const WallClusters& clusters = scene.clusters;
  const auto count = std::size_t(clusters.count());
  view.wall_count = scene.wall_count;
  view.cluster_count = clusters.count();
  view.wall_colors = int(scene.wall_color_begin.size()) - 1;
  view.wall_color_begin = memory.store(scene.wall_color_begin);
  view.cluster_begin = memory.store(clusters.begin);
  view.cluster_vertex = memory.store(clusters.vertex);
  view.cluster_stiffness = memory.store(converted_all<Real>(clusters.stiffness));
  view.cluster_offset = memory.store(converted_all<Real>(clusters.offset));
  std::vector<Vec3> centres(count);
  std::vector<double> mode_scale(count, 0.0);
  std::vector<double> goal_stiffness(std::size_t(scene.wall_count), 0.0);
  for (std::size_t c = 0; c < count; ++c) {
    double weight = 0.0, spread = 0.0;
    for (int e = clusters.begin[c]; e < clusters.begin[c + 1]; ++e) {
      const auto i = std::size_t(e);
      const auto v = std::size_t(clusters.vertex[i]);
      centres[c] += clusters.stiffness[i] * scene.start[std::size_t(scene.balloon_count) + v];
      weight += clusters.stiffness[i];
      goal_stiffness[v] += clusters.stiffness[i];
      spread += clusters.stiffness[i] * norm_squared(clusters.offset[i]);
    }
    mode_scale[c] = 1.0 / spread;
    centres[c] = centres[c] / weight;
  }
  view.cluster_start = memory.store(local<Real>(scene, centres));
  view.cluster_axis = memory.store(converted_all<Real>(clusters.axis));
  view.cluster_along = memory.store(converted_all<Real>(clusters.along));
  view.entry_along = memory.store(converted_all<Real>(places_along(clusters)));
  view.cluster_normal = memory.store(converted_all<Real>(clusters.axis));
  view.entry_begin = memory.store(clusters.entry_begin);
  view.entry = memory.store(clusters.entry);
  view.entry_cluster = memory.store(clusters.entry_cluster);
  view.neighbor_begin = memory.store(scene.neighbor_begin);
  view.neighbors = memory.store(scene.neighbors);
  view.foundation = memory.store(converted_all<Real>(scene.foundation));
  view.goal_stiffness = memory.store(converted_all<Real>(goal_stiffness));
  const std::vector<Mat3T<Real>> identity(count, Mat3T<Real>::identity());
  view.cluster_rotation = memory.store(identity);
  view.cluster_plastic = memory.store(identity);
  view.cluster_map = memory.store(identity);
  if (!clusters.modes.empty()) {
    view.entry_modes = memory.store(converted_all<Real>(clusters.modes));
    view.mode_scale = memory.store(converted_all<Real>(mode_scale));
    view.mode_freedom = Real(wall.shape_beta);
    const std::vector<Vec3T<Real>> flat(count * kShapeModes);
    view.cluster_plastic_modes = memory.store(flat);
    view.cluster_map_modes = memory.store(flat);
  }
  view.cluster_centre = memory.template allocate<Vec3T<Real>>(count);
  view.goal = memory.template allocate<Vec3T<Real>>(std::size_t(scene.wall_count));
  view.wall_move = memory.template allocate<Vec3T<Real>>(std::size_t(scene.wall_count));
  view.along_force = memory.template allocate<Vec3T<Real>>(std::size_t(scene.wall_count));
  view.along_stiffness = memory.template allocate<Mat3T<Real>>(std::size_t(scene.wall_count));
  add_wall_corners(scene, memory, view);
  view.contact_pressure = memory.template allocate<Real>(std::size_t(scene.wall_count));
}

template <class To, class From>
SolidPoint<To> converted(const SolidPoint<From>& point) {
  SolidPoint<To> result;
  for (int a = 0; a < 6; ++a) result.g[a] = converted<To>(point.g[a]);
  result.weight = To(point.weight);
  return result;
}

template <class Real>
SolidLaw<Real> converted(const SolidLaw<double>& law) {
  return {Real(law.shear), Real(law.bulk),  Real(law.k1),   Real(law.k2),
          Real(law.share), Real(law.yield), Real(law.creep)};
}

/// The layered wall in place of the slabs; to be called when view.x and the wall are there.
template <class Real, class Memory>
void add_solid_view(const Scene& scene, Memory& memory, StepView<Real>& view) {
  const WallSolid& wall = scene.solid;
  const SolidModel& model = wall.model;
  view.cluster_count = 0;
  view.wedge_count = model.wedge_count();
  view.solid_points = memory.store(converted_all<Real>(model.points));
  view.solid_plastic_strain = memory.store(std::vector<Real>(model.points.size()));
  SolidView<Real>& solid = view.solid;
  solid.x = view.x + scene.balloon_count;
  solid.corners = memory.store(model.corners);
  solid.points = view.solid_points;
  solid.fibers = memory.store(converted_all<Real>(model.fibers));
  solid.region = memory.store(model.region);
  solid.laws = memory.store(converted_all<Real>(model.laws));
  solid.patch = memory.store(model.patch);
  solid.patch_begin = memory.store(model.patch_begin);
  solid.patch_wedges = memory.store(model.patch_wedges);
  solid.patch_volume = memory.store(converted_all<Real>(model.patch_volume));
  view.columns.levels = wall.levels;
  view.columns.stride = scene.wall_count;
  view.columns.layer = memory.store(wall.wall.layer);
  view.columns.patch_begin = memory.store(wall.patch_begin);
  view.columns.patches = memory.store(wall.patches);
  view.blood_pressure = Real(wall.blood_pressure);
  const auto outer = model.foundation.end() - scene.wall_count;
  view.foundation =
      memory.store(converted_all<Real>(std::vector<double>(outer, model.foundation.end())));
}

/// The guidewire, if there is one.
template <class Real, class Memory>
void add_rod_view(const Scene& scene, Memory& memory, StepView<Real>& view) {
  const SceneRod& rod = scene.rod;
  if (rod.count == 0) return;
  const auto count = std::size_t(rod.count), parts = count + rod.ties.size();
  RodView<Real>& out = view.rod;
  out.first = rod.first;
  out.shape = {rod.count, memory.store(rod.rest), memory.store(rod.bend)};
  out.section = rod.section;
  out.held = memory.store(rod.held);
  out.tie_count = int(rod.ties.size());
  out.ties = memory.store(rod.ties);
  out.loads = memory.template allocate<RodLoad<Real>>(parts);
  out.x = memory.template allocate<Vec3>(2 * count);
  out.external = memory.template allocate<RodRow<double>>(count);
  out.rows = memory.template allocate<RodRow<double>>(count);
  out.share = memory.template allocate<Real>(parts);
  out.report = memory.template allocate<RodReport>(1);
}

/// The gap beyond which nothing acts between two surfaces [mm].
inline double contact_range(const SimulationOptions& options) {
  return options.adhesion_traction_kpa > 0.0
             ? std::max(options.contact_distance_mm, options.adhesion_gap_2_mm)
             : options.contact_distance_mm;
}

/// What the paper's contact projects, colour by colour.
struct PaperTets {
  std::vector<int> vertices;  ///< four a tet, those of the balloon first, right-handed
  std::vector<int> balloon_corners;
  std::vector<int> color_begin;           ///< tet
  std::vector<double> inverse_mass;       ///< [1/g], shape [vertex]; 0: held
  double volume_1 = 0.0, volume_2 = 0.0;  ///< [mm^3]
};

/// @param air  right-handed tets
/// @throws InputError if there are none
PaperTets paper_tets(const Scene& scene, const SimulationOptions& options,
                     const std::vector<Tet>& air);

/// The viscous items of the tets that stay, as `now` has them.
///
/// @param triggered  shape [tet of `before`]
std::vector<char> kept_items(const PaperTets& before, const std::vector<char>& triggered,
                             const PaperTets& now);

/// The tets of the paper's gas: each triangle of the balloon with the guidewire's nearest node.
/// Those that enclose nothing at the start, at the ends, get no gas. Colour by colour.
struct PaperGasTets {
  std::vector<Vec3> apex;        ///< [mm], shape [tet]
  std::vector<int> triangles;    ///< three vertices a tet
  std::vector<double> volume;    ///< at the start [mm^3], > 0
  std::vector<int> color_begin;  ///< tet
  double whole = 0.0;            ///< what the balloon encloses then [mm^3]
};

/// @throws InputError if there is no guidewire
PaperGasTets paper_gas_tets(const Scene& scene);

/// k sum Q / sum V over the tets: the pressure that a frame of the paper's gas reports [Pa].
///
/// @param growth  of their targets over their volumes at the start
double mean_tet_pressure(const PaperGasTets& tets, double growth, double outside,
                         const std::vector<Vec3>& x);

/// The paper's gas. Without the prediction, and with no step beyond a vertex's own: what is
/// projected is no motion to go on with, and the balloon would collapse.
template <class Real, class Memory>
void add_paper_gas_view(const Scene& scene, Memory& memory, StepView<Real>& view) {
  const PaperGasTets tets = paper_gas_tets(scene);
  view.relaxation = Real(1);
  PaperGas<Real>& gas = view.paper_gas;
  gas.is_on = true;
  gas.colors = int(tets.color_begin.size()) - 1;
  gas.color_begin = memory.store(tets.color_begin);
  gas.whole = tets.whole;
  gas.apex = memory.store(local<Real>(scene, tets.apex));
  gas.triangles = memory.store(tets.triangles);
  std::vector<Real> inverse_mass;
  for (std::size_t v = 0; v < scene.mass.size(); ++v)
    inverse_mass.push_back(scene.fixed[v] ? Real(0) : Real(1.0 / scene.mass[v]));
  gas.inverse_mass = memory.store(inverse_mass);
  gas.volume = memory.store(converted_all<Real>(tets.volume));
}

/// The paper's contact: the air tets between the surfaces, balloon vertices first.
template <class Real, class Memory>
void add_paper_view(const Scene& scene, const SimulationOptions& options, Memory& memory,
                    StepView<Real>& view) {
  std::vector<Tet> air = scene.air;
  const auto at = [&](int v) { return scene.start[std::size_t(v)]; };
  for (Tet& t : air)
    if (tet_volume(at(t[0]), at(t[1]), at(t[2]), at(t[3])) < 0.0) std::swap(t[0], t[1]);
  const PaperTets tets = paper_tets(scene, options, air);
  PaperContact<Real>& paper = view.paper;
  paper.is_on = true;
  paper.colors = int(tets.color_begin.size()) - 1;
  paper.color_begin = memory.store(tets.color_begin);
  paper.tets = memory.store(tets.vertices);
  paper.balloon_corners = memory.store(tets.balloon_corners);
  paper.inverse_mass = memory.store(converted_all<Real>(tets.inverse_mass));
  paper.triggered = memory.store(std::vector<char>(tets.balloon_corners.size(), 0));
  paper.volume_1 = Real(tets.volume_1);
  paper.volume_2 = Real(tets.volume_2);
}

template <class Real, class Memory>
StepView<Real> make_view(const Scene& scene, const SimulationOptions& options, Memory& memory) {
  constexpr double kRelaxation = 1.6;  // fastest on an inflating capsule
  // Slip speed below which contact sticks, contact distances a second: 0.02 mm/s at 0.03 mm.
  constexpr double kStickSpeed = 2.0 / 3.0;
  const double peak = units::pascal_from_atm(options.inflation.peak_pressure_atm);
  StepView<Real> view;
  add_balloon_view(scene, memory, view);
  add_wall_view(scene, options.wall, memory, view);
  view.dt = Real(options.frame_s);
  view.outside_pressure = Real(outside_pressure(options));
  view.contact_distance = Real(options.contact_distance_mm);
  view.contact_stiffness =
      Real(options.contact_stiffness * barrier_stiffness(peak, options.contact_distance_mm));
  view.relaxation = Real(kRelaxation);
  view.friction = {Real(options.friction_static), Real(options.friction_kinetic),
                   Real(kStickSpeed * options.contact_distance_mm * options.frame_s)};
  view.contact_range = Real(contact_range(options));
  view.self_distance = Real(scene.self_distance);
  view.has_folds = scene.has_folds;
  const bool paper = options.contact_model == ContactModel::paper;
  if (paper && scene.wall_count > 0) add_paper_view(scene, options, memory, view);
  if (options.gas_model == GasModel::per_tet) add_paper_gas_view(scene, memory, view);
  if (!paper && options.adhesion_traction_kpa > 0.0 && scene.wall_count > 0) {
    view.adhesion = {Real(units::pascal_from_kilopascal(options.adhesion_traction_kpa)),
                     Real(options.adhesion_gap_1_mm), Real(options.adhesion_gap_2_mm)};
    view.wet = memory.store(std::vector<char>(scene.start.size(), 0));
  }
  const std::size_t count = scene.start.size();
  view.start = memory.store(local<Real>(scene, scene.start));
  view.x = memory.store(local<Real>(scene, scene.start));
  view.x_before = memory.template allocate<Vec3T<Real>>(count);
  view.x_inertial = memory.template allocate<Vec3T<Real>>(count);
  view.velocity = memory.template allocate<Vec3T<Real>>(count);
  view.area = memory.template allocate<Real>(count);
  view.x_searched = memory.template allocate<Vec3T<Real>>(count);
  view.x_swept = memory.template allocate<Vec3T<Real>>(count);
  view.swept_by = memory.template allocate<Vec3T<Real>>(count);
  view.gone = memory.template allocate<Real>(count);
  view.travel = memory.template allocate<Real>(count);
  view.owned_end = memory.template allocate<int>(count);
  view.ref_end = memory.template allocate<int>(count);
  view.bound_end = memory.template allocate<int>(count);
  view.mass = memory.store(converted_all<Real>(scene.mass));
  view.vertex_count = scene.vertex_count();
  if (scene.solid.levels > 0) add_solid_view(scene, memory, view);
  add_rod_view(scene, memory, view);
  return view;
}

template <class Real>
PlasticFlow<Real> plastic_flow(const WallMaterial& wall) {
  return {Real(wall.yield_strain), Real(wall.creep_per_s), Real(wall.max_plastic_strain)};
}

StepRules make_rules(const Scene& scene, const SimulationOptions& options);

/// Finds a run's candidates, on the host, from positions relative to the scene's origin.
class CandidateFinder {
 public:
  /// @param frames  that a set of candidates should last: their reach follows from how long the
  ///                last set did
  /// @param lists   are the candidates of each vertex listed (CandidateSet::refs)?
  CandidateFinder(const Scene& scene, const SimulationOptions& options, int frames,
                  bool lists = true)
      : scene_(scene),
        distance_(options.contact_distance_mm),
        range_(contact_range(options)),
        of_wall_(options.contact_model == ContactModel::barrier),
        frames_(frames),
        lists_(lists) {}

  /// @param lasted  frames that were begun with the last set
  CandidateSet find(const std::vector<Vec3>& x, int lasted);

 private:
  static constexpr double kLeastSlack = 1.0, kMostSlack = 20.0;  // over the contact distance
  static constexpr double kOwnSlack = 1.5;                       // of pairs of one surface

  /// Pairs of the balloon with the wall and the guidewire, within `reach_`.
  [[nodiscard]] std::vector<Candidate> find_others(const std::vector<Vec3>& x);
  [[nodiscard]] double closed_at_most(const std::vector<Vec3>& x) const;

  const Scene& scene_;
  double distance_, range_, slack_ = 4.0, reach_ = 0.0;
  bool of_wall_;  // else only the guidewire's: the paper's contact has none
  int frames_, lasted_ = 0;
  bool lists_;
  bool first_ = true;
  // With pairs of one surface: the others as they were found last.
  std::vector<Candidate> others_;
  std::vector<Vec3> x_others_;
};

/// What a step reads of a set of candidates, in a backend's memory.
template <class Real>
struct CandidateView {
  const Candidate* candidates = nullptr;
  const int* owned_begin = nullptr;
  const int* ref_begin = nullptr;
  const ContactRef* refs = nullptr;
  const Vec3T<Real>* x = nullptr;
  Real reach = 0;
  int count = 0;
  Real skin_reach = 0;
};

template <class Real>
void use(const CandidateView<Real>& set, StepView<Real>& view) {
  view.candidates = set.candidates;
  view.owned_begin = set.owned_begin;
  view.ref_begin = set.ref_begin;
  view.candidate_refs = set.refs;
  view.x_candidates = set.x;
  view.candidate_reach = set.reach;
  view.candidate_count = set.count;
  view.skin_reach = set.skin_reach;
}

}  // namespace angio::simulation::detail
