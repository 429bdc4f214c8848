#pragma once

#include <algorithm>
#include <vector>

#include "core/tet_mesh.hpp"
#include "core/units.hpp"
#include "simulation/contact/candidate_finder.hpp"
#include "simulation/contact/contact_force.hpp"
#include "simulation/pbd/make_view.hpp"
#include "simulation/pbd/policy.hpp"
#include "simulation/run/schedule.hpp"
#include "simulation/step/convert.hpp"
#include "simulation/step/views.hpp"

/// From a scene in double precision to the arrays of a step, in the computer's memory. `Memory`
/// stores and allocates arrays, as HostMemory does.
namespace angio::simulation::detail {

inline std::vector<int> flattened(const std::vector<Triangle>& triangles) {
  std::vector<int> result;
  for (const Triangle& t : triangles) result.insert(result.end(), t.begin(), t.end());
  return result;
}

/// All bodies. To be linked when the other views are there.
template <class Real, class Memory>
MotionView<Real> make_motion_view(const Scene& scene, double dt, Memory& memory) {
  const std::size_t count = scene.start.size();
  MotionView<Real> view;
  view.count = scene.vertex_count();
  view.dt = Real(dt);
  view.start = memory.store(local<Real>(scene, scene.start));
  view.x = memory.store(local<Real>(scene, scene.start));
  view.x_before = memory.template allocate<Vec3T<Real>>(count);
  view.x_inertial = memory.template allocate<Vec3T<Real>>(count);
  view.velocity = memory.template allocate<Vec3T<Real>>(count);
  view.area = memory.template allocate<Real>(count);
  view.x_searched = memory.template allocate<Vec3T<Real>>(count);
  view.x_swept = memory.template allocate<Vec3T<Real>>(count);
  view.swept_by = memory.template allocate<Vec3T<Real>>(count);
  view.mass = memory.store(converted_all<Real>(scene.mass));
  return view;
}

template <class Real, class Memory>
BalloonView<Real> make_balloon_view(const Scene& scene, const SimulationOptions& options,
                                    Memory& memory) {
  constexpr double kRelaxation = 1.6;  // fastest on an inflating capsule
  BalloonView<Real> view;
  view.outside_pressure = Real(outside_pressure(options));
  view.relaxation = pbd_policy(options).goes_on() ? Real(kRelaxation) : Real(1);
  view.has_folds = scene.balloon.has_folds;
  view.triangle_count = int(scene.balloon.triangles.size());
  view.mesh.first = scene.bodies.balloon().first;
  view.mesh.count = scene.bodies.balloon().count;
  view.mesh.corner_count = int(scene.balloon.corners.size());
  view.mesh.colors = int(scene.balloon.color_begin.size()) - 1;
  view.mesh.color_begin = memory.store(scene.balloon.color_begin);
  view.triangles = memory.store(flattened(scene.balloon.triangles));
  view.mesh.corner_begin = memory.store(scene.balloon.corner_begin);
  std::vector<CornerLink> links;
  std::vector<CornerMetric<Real>> rest, start;
  for (const Corner& corner : scene.balloon.corners) {
    links.push_back({corner.next, corner.last});
    rest.push_back(converted<Real>(corner.rest));
    if (scene.balloon.membrane.relaxed) start.push_back(converted<Real>(corner.start));
  }
  view.mesh.corners = memory.store(links);
  view.rest = memory.store(rest);
  if (!start.empty()) view.start_rest = memory.store(start);
  view.law = converted<Real>(scene.balloon.membrane);
  view.folds = converted<Real>(scene.balloon.folds);
  view.moves = memory.template allocate<Move<Real>>(std::size_t(scene.bodies.balloon().count));
  return view;
}

/// The triangles around each vertex of the wall.
template <class Memory>
MeshView make_wall_mesh(const Scene& scene, Memory& memory) {
  const BodyRange& wall = scene.bodies.wall();
  std::vector<std::vector<CornerLink>> corners(std::size_t(wall.count));
  for (const Triangle& t : scene.wall.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      corners[std::size_t(t[k] - wall.first)].push_back({t[(k + 1) % 3], t[(k + 2) % 3]});
  std::vector<CornerLink> links;
  std::vector<int> corner_begin{0};
  for (const std::vector<CornerLink>& list : corners) {
    links.insert(links.end(), list.begin(), list.end());
    corner_begin.push_back(int(links.size()));
  }
  return {wall.first,
          wall.count,
          int(scene.wall.color_begin.size()) - 1,
          int(links.size()),
          memory.store(scene.wall.color_begin),
          memory.store(corner_begin),
          memory.store(links)};
}

template <class Real, class Memory>
WallView<Real> make_wall_view(const Scene& scene, Memory& memory) {
  const auto count = std::size_t(scene.bodies.wall().count);
  WallView<Real> view;
  view.mesh = make_wall_mesh(scene, memory);
  view.move = memory.template allocate<Vec3T<Real>>(count);
  view.contact_pressure = memory.template allocate<Real>(count);
  if (scene.wall.solid.levels == 0) {
    view.foundation = memory.store(converted_all<Real>(scene.wall.foundation));
  } else {
    const std::vector<double>& springs = scene.wall.solid.model.foundation;
    const auto outer = springs.end() - std::ptrdiff_t(count);
    view.foundation = memory.store(converted_all<Real>(std::vector<double>(outer, springs.end())));
  }
  return view;
}

/// Of each slab's members along its axis [mm], shape [slab vertex].
inline std::vector<double> places_along(const WallSlabs& slabs) {
  std::vector<double> along;
  for (std::size_t c = 0; c < std::size_t(slabs.count()); ++c)
    for (int e = slabs.begin[c]; e < slabs.begin[c + 1]; ++e)
      along.push_back(dot(slabs.axis[c], slabs.offset[std::size_t(e)]));
  return along;
}

template <class Real, class Memory>
SlabFitView<Real> make_slab_fit(const WallSlabs& slabs, Memory& memory) {
  const auto count = std::size_t(slabs.count());
  SlabFitView<Real> view;
  view.count = slabs.count();
  view.vertex_count = int(slabs.vertex.size());
  view.place_along = memory.store(converted_all<Real>(places_along(slabs)));
  view.axis = memory.store(converted_all<Real>(slabs.axis));
  const std::vector<Mat3T<Real>> identity(count, Mat3T<Real>::identity());
  view.rotation = memory.store(identity);
  view.plastic = memory.store(identity);
  view.map = memory.store(identity);
  if (!slabs.modes.empty()) {
    const std::vector<Vec3T<Real>> flat(count * kShapeModes);
    view.plastic_modes = memory.store(flat);
    view.map_modes = memory.store(flat);
  }
  view.centre = memory.template allocate<Vec3T<Real>>(count);
  return view;
}

template <class Real, class Memory>
SlabsView<Real> make_slabs_view(const Scene& scene, const WallMaterial& wall, Memory& memory) {
  const WallSlabs& slabs = scene.wall.slabs;
  const auto count = std::size_t(slabs.count()), vertices = std::size_t(scene.bodies.wall().count);
  SlabsView<Real> view;
  view.count = scene.wall.solid.levels > 0 ? 0 : slabs.count();
  SlabShapeView<Real>& shape = view.shape;
  shape.count = slabs.count();
  shape.vertex_count = int(slabs.vertex.size());
  shape.begin = memory.store(slabs.begin);
  shape.vertex = memory.store(slabs.vertex);
  shape.stiffness = memory.store(converted_all<Real>(slabs.stiffness));
  shape.offset = memory.store(converted_all<Real>(slabs.offset));
  std::vector<Vec3> centres(count);
  std::vector<double> mode_scale(count, 0.0);
  std::vector<double> goal_stiffness(vertices, 0.0);
  for (std::size_t c = 0; c < count; ++c) {
    double weight = 0.0, spread = 0.0;
    for (int e = slabs.begin[c]; e < slabs.begin[c + 1]; ++e) {
      const auto i = std::size_t(e);
      const auto v = std::size_t(slabs.vertex[i]);
      centres[c] += slabs.stiffness[i] * scene.start[std::size_t(scene.bodies.wall().first) + v];
      weight += slabs.stiffness[i];
      goal_stiffness[v] += slabs.stiffness[i];
      spread += slabs.stiffness[i] * norm_squared(slabs.offset[i]);
    }
    mode_scale[c] = 1.0 / spread;
    centres[c] = centres[c] / weight;
  }
  shape.start = memory.store(local<Real>(scene, centres));
  shape.axis = memory.store(converted_all<Real>(slabs.axis));
  shape.along = memory.store(converted_all<Real>(slabs.along));
  if (!slabs.modes.empty()) {
    shape.modes = memory.store(converted_all<Real>(slabs.modes));
    shape.mode_scale = memory.store(converted_all<Real>(mode_scale));
    shape.mode_freedom = Real(wall.shape_beta);
  }
  view.fit = make_slab_fit<Real>(slabs, memory);
  view.goals = {int(vertices),
                int(slabs.slab_vertices.size()),
                int(scene.wall.neighbors.size()),
                memory.store(slabs.slab_vertex_begin),
                memory.store(slabs.slab_vertices),
                memory.store(slabs.slab_of),
                memory.store(scene.wall.neighbor_begin),
                memory.store(scene.wall.neighbors),
                memory.store(converted_all<Real>(goal_stiffness)),
                memory.template allocate<Vec3T<Real>>(vertices),
                memory.template allocate<Mat3T<Real>>(vertices),
                memory.template allocate<Vec3T<Real>>(vertices)};
  return view;
}

/// Without tangents: the first sweep takes them.
template <class Real, class Memory>
ColumnRows<Real> make_column_rows(const LayeredWallView<Real>& view, Memory& memory) {
  const auto wedges = std::size_t(view.wedge_count), links = std::size_t(view.link_count),
             levels = std::size_t(view.columns.levels), patches = std::size_t(view.patch_count),
             rows = levels * std::size_t(view.columns.stride),
             column_patches = std::size_t(view.column_patch_count);
  ColumnRows<Real> out;
  out.places = memory.template allocate<WedgePlace<Real>>(wedges);
  out.tangents = memory.template allocate<WedgeTangent<Real>>(wedges);
  out.forces = memory.template allocate<WedgeForce<Real>>(wedges);
  out.renewed = memory.template allocate<Renewed>(wedges);
  out.wedge_volume = memory.template allocate<Real>(wedges);
  out.patch_volume = memory.template allocate<Real>(patches);
  out.constant = memory.template allocate<Vec3T<Real>>(rows);
  out.pivot = memory.template allocate<Mat3T<Real>>(rows);
  out.upper = memory.template allocate<Mat3T<Real>>(rows);
  out.above = memory.template allocate<Mat3T<Real>>(rows);
  out.beside = memory.template allocate<Slope>(3 * levels * links);
  out.by_low = memory.template allocate<Vec3T<Real>>(column_patches);
  out.by_high = memory.template allocate<Vec3T<Real>>(column_patches);
  out.steepness = memory.template allocate<Real>(std::size_t(view.columns.stride));
  return out;
}

template <class Real, class Memory>
LayeredWallView<Real> make_layered_view(const Scene& scene, Memory& memory) {
  const WallSolid& wall = scene.wall.solid;
  const SolidModel& model = wall.model;
  LayeredWallView<Real> view;
  if (wall.levels == 0) return view;
  view.wedge_count = model.wedge_count();
  view.patch_count = model.patch_count();
  view.region_count = int(model.laws.size());
  view.column_patch_count = int(wall.columns.patches.size());
  view.column_wedge_count = int(wall.columns.wedges.size());
  view.link_count = int(wall.columns.links.size());
  view.points = memory.store(converted_all<Real>(model.points));
  view.plastic_strain = memory.store(std::vector<Real>(model.points.size()));
  SolidView<Real>& solid = view.solid;
  solid.corners = memory.store(model.corners);
  solid.fibers = memory.store(converted_all<Real>(model.fibers));
  solid.region = memory.store(model.region);
  solid.laws = memory.store(converted_all<Real>(model.laws));
  solid.patch = memory.store(model.patch);
  solid.patch_begin = memory.store(model.patch_begin);
  solid.patch_wedges = memory.store(model.patch_wedges);
  solid.patch_volume = memory.store(converted_all<Real>(model.patch_volume));
  solid.patch_bulk = memory.store(converted_all<Real>(model.patch_bulk));
  view.columns = {wall.levels,
                  scene.bodies.wall().count,
                  memory.store(wall.wall.layer),
                  memory.store(wall.columns.patch_begin),
                  memory.store(wall.columns.patches),
                  memory.store(wall.columns.wedge_begin),
                  memory.store(wall.columns.wedges),
                  memory.store(wall.columns.link_begin),
                  memory.store(wall.columns.links)};
  view.led = memory.store(wall.led);
  view.rows = make_column_rows<Real>(view, memory);
  view.blood_pressure = Real(wall.blood_pressure);
  return view;
}

/// The guidewire, if there is one.
template <class Real, class Memory>
GuidewireView<Real> make_guidewire_view(const Scene& scene, Memory& memory) {
  const SceneRod& rod = scene.rod;
  GuidewireView<Real> view;
  if (rod.count == 0) return view;
  const auto count = std::size_t(rod.count), parts = count + rod.ties.size();
  view.first = scene.bodies.guidewire().first;
  view.shape = {rod.count, memory.store(rod.rest), memory.store(rod.bend)};
  view.section = rod.section;
  view.tie_count = int(rod.ties.size());
  view.held = memory.store(rod.held);
  view.ties = memory.store(rod.ties);
  view.loads = memory.template allocate<RodLoad<Real>>(parts);
  view.x = memory.template allocate<Vec3>(2 * count);
  view.external = memory.template allocate<RodRow<double>>(count);
  view.rows = memory.template allocate<RodRow<double>>(count);
  view.share = memory.template allocate<Real>(parts);
  view.report = memory.template allocate<RodReport>(1);
  return view;
}

/// The distal neck, if it slides.
template <class Real, class Memory>
SlideView<Real> make_slide_view(const Scene& scene, Memory& memory) {
  SlideView<Real> view;
  view.count = int(scene.slide.vertices.size());
  if (view.count == 0) return view;
  view.along = converted<Real>(scene.slide.along);
  view.vertices = memory.store(scene.slide.vertices);
  view.loads = memory.template allocate<SlideLoad<Real>>(scene.slide.vertices.size());
  return view;
}

template <class Real, class Memory>
ContactView<Real> make_contact_view(const Scene& scene, const SimulationOptions& options,
                                    Memory& memory) {
  // Slip speed below which contact sticks, contact distances a second: 0.02 mm/s at 0.03 mm.
  constexpr double kStickSpeed = 2.0 / 3.0;
  const double peak = units::pascal_from_atm(options.inflation.peak_pressure_atm);
  const std::size_t count = scene.start.size();
  ContactView<Real> view;
  view.vertex_count = int(count);
  ContactLaw<Real>& law = view.law;
  law.distance = Real(options.contact.distance_mm);
  law.stiffness =
      Real(options.contact.stiffness * barrier_stiffness(peak, options.contact.distance_mm));
  law.friction = {Real(options.contact.friction_static), Real(options.contact.friction_kinetic),
                  Real(kStickSpeed * options.contact.distance_mm * options.frame_s)};
  law.range = Real(contact_range(options));
  law.self_distance = Real(scene.self_distance);
  if (!pbd_policy(options).contact && options.contact.adhesion_traction_kpa > 0.0 &&
      scene.bodies.wall().count > 0) {
    law.adhesion = {Real(units::pascal_from_kilopascal(options.contact.adhesion_traction_kpa)),
                    Real(options.contact.adhesion_gap_1_mm),
                    Real(options.contact.adhesion_gap_2_mm)};
    view.wet = memory.store(std::vector<char>(count, 0));
  }
  NearPairView<Real>& near = view.near;
  near.moved = memory.template allocate<Real>(count);
  near.max_move = memory.template allocate<Real>(count);
  near.owned_end = memory.template allocate<int>(count);
  near.ref_end = memory.template allocate<int>(count);
  near.bound_end = memory.template allocate<int>(count);
  return view;
}

template <class Real, class Memory>
StepView<Real> make_view(const Scene& scene, const SimulationOptions& options, Memory& memory) {
  StepView<Real> view;
  view.bodies = scene.bodies;
  view.motion = make_motion_view<Real>(scene, options.frame_s, memory);
  view.balloon = make_balloon_view<Real>(scene, options, memory);
  view.wall = make_wall_view<Real>(scene, memory);
  view.slabs = make_slabs_view<Real>(scene, options.wall, memory);
  view.layered = make_layered_view<Real>(scene, memory);
  view.guidewire = make_guidewire_view<Real>(scene, memory);
  view.slide = make_slide_view<Real>(scene, memory);
  view.contact = make_contact_view<Real>(scene, options, memory);
  view.pbd = make_pbd_view<Real>(scene, options, memory);
  view.link();
  return view;
}

template <class Real>
PlasticFlow<Real> plastic_flow(const WallMaterial& wall) {
  return {Real(wall.yield_strain), Real(wall.creep_per_s), Real(wall.max_plastic_strain)};
}

}  // namespace angio::simulation::detail
