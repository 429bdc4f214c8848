#include "simulation/bodies/scene.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/bodies/numbering.hpp"
#include "simulation/bodies/scene_check.hpp"
#include "simulation/contact/candidates.hpp"
#include "simulation/materials/material.hpp"
#include "simulation/pbd/policy.hpp"
#include "simulation/run/measure.hpp"
#include "simulation/step/near_pairs.hpp"

namespace angio::simulation::detail {
namespace {

// Share of the membrane's stiffness that the folds have against being spread: it only shapes a
// slack balloon (a pressure of the order of 0.1 atm at most).
constexpr double kFoldShare = 1e-3;

void check_layered(const SimulationModel& model, const SimulationOptions& options) {
  simulation::check_wall(model.layered_wall, options.layered_wall);
  const std::size_t count = model.wall.vertices.size();
  bool same = model.layered_wall.vertices.size() > count;
  for (std::size_t v = 0; v < count && same; ++v)
    same = distance(model.layered_wall.vertices[v], model.wall.vertices[v]) < 1e-6;
  if (!same)
    throw InputError(
        "the layered wall's first vertices are not those of the lumen's wall (the files belong to "
        "different runs). Run the stage meshing again");
}

// The guidewire where it runs through the rest shape, as in a balloon that starts at rest. Else
// that shape stands straight, in a frame of its own, and its longest extent is its axis.
std::vector<Vec3> axis_of_rest(const SimulationModel& model) {
  for (std::size_t v = 0; v < model.balloon_rest.size(); ++v)
    if (distance(model.balloon_rest[v], model.balloon.vertices[v]) > 1e-6) return {};
  return model.guidewire;
}

void add_corners(const SimulationModel& model, Scene& scene) {
  const auto& mesh = model.balloon;
  scene.balloon.corner_begin.assign(mesh.vertices.size() + 1, 0);
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) ++scene.balloon.corner_begin[std::size_t(v) + 1];
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    scene.balloon.corner_begin[v + 1] += scene.balloon.corner_begin[v];
  scene.balloon.corners.resize(3 * mesh.triangles.size());
  std::vector<int> next(scene.balloon.corner_begin.begin(), scene.balloon.corner_begin.end() - 1);
  std::vector<Vec3> fibres(mesh.triangles.size());
  if (scene.balloon.membrane.fibre.count > 0)
    fibres = hoop_fibres(mesh.triangles, model.balloon_rest, axis_of_rest(model));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const Triangle& t = mesh.triangles[i];
      const auto v = std::size_t(t[k]), n = std::size_t(t[(k + 1) % 3]),
                 m = std::size_t(t[(k + 2) % 3]);
      Corner corner;
      corner.next = int(n);
      corner.last = int(m);
      corner.rest = corner_metric(model.balloon_rest[v], model.balloon_rest[n],
                                  model.balloon_rest[m], scene.balloon.thickness, fibres[i]);
      corner.start = corner_metric(mesh.vertices[v], mesh.vertices[n], mesh.vertices[m],
                                   scene.balloon.thickness);
      scene.balloon.corners[std::size_t(next[v]++)] = corner;
    }
}

void add_balloon(const SimulationModel& model, const SimulationOptions& options, Scene& scene) {
  scene.balloon.membrane = membrane_law(options.balloon);
  scene.balloon.thickness = options.balloon.wall_mm;
  double size = 0.0, change = 0.0;
  for (std::size_t v = 0; v < model.balloon_rest.size(); ++v) {
    size = std::max(size, distance(model.balloon_rest[v], model.balloon_rest[0]));
    change = std::max(change, distance(model.balloon_rest[v], model.balloon.vertices[v]));
  }
  scene.balloon.membrane.relaxed =
      options.membrane == MembraneModel::relaxed ||
      (options.membrane == MembraneModel::automatic && change > 1e-9 * size);
  if (scene.balloon.membrane.relaxed)
    scene.balloon.folds = {kFoldShare * scene.balloon.membrane.base.c1,
                           kFoldShare * scene.balloon.membrane.base.c2};
  add_corners(model, scene);
  TriangleMesh rest = model.balloon;
  rest.vertices = model.balloon_rest;
  scene.balloon.rest_radius = 2.0 * enclosed_volume(rest) / surface_area(rest);
  const auto areas = vertex_areas(rest);
  for (std::size_t v = 0; v < areas.size(); ++v)
    scene.mass[v] = density(options.balloon) * scene.balloon.thickness * areas[v];
  scene.balloon.triangles = model.balloon.triangles;
  scene.balloon.edges = unique_edges(model.balloon);
}

void add_wall(const SimulationModel& model, const SimulationOptions& options, Scene& scene) {
  scene.wall.slabs = make_slabs(model, options.wall);
  scene.wall.area = vertex_areas(model.wall);
  const auto offset = std::size_t(scene.bodies.wall().first);
  const double ratio = options.wall.thickness_ratio;
  const double thickness = 2.0 * model.reference_radius_mm * ratio / (1.0 - 2.0 * ratio);
  const double foundation = units::pascal_from_kilopascal(options.wall.foundation_kpa_per_mm);
  for (std::size_t v = 0; v < scene.wall.area.size(); ++v) {
    scene.wall.foundation.push_back(foundation * scene.wall.area[v]);
    scene.mass[offset + v] = options.wall.density_g_mm3 * thickness * scene.wall.area[v];
  }
  scene.wall.neighbor_begin.push_back(0);
  for (const auto& ring : vertex_neighbors(model.wall)) {
    for (const int n : ring) scene.wall.neighbors.push_back(int(offset) + n);
    scene.wall.neighbor_begin.push_back(int(scene.wall.neighbors.size()));
  }
  for (Triangle t : model.wall.triangles) {
    for (int& v : t) v += int(offset);
    scene.wall.triangles.push_back(t);
  }
  for (Edge e : unique_edges(model.wall)) {
    for (int& v : e) v += int(offset);
    scene.wall.edges.push_back(e);
  }
}

void add_solid(const SimulationOptions& options, const SimulationModel& given,
               const Numbering& wall, Scene& scene) {
  scene.wall.solid =
      make_wall_solid(given.layered_wall, wall.order, options.layered_wall, given.wall_seen.get());
  const auto first = std::size_t(scene.bodies.wall().count);
  const std::vector<char>& fixed = scene.wall.solid.wall.fixed;
  std::vector<char>& led = scene.wall.solid.led;
  led.assign(first, 0);
  for (std::size_t v = 0; v < fixed.size(); ++v) led[v % first] |= char(fixed[v] != 0);
  for (std::size_t i = 0; i < first; ++i)
    if (scene.fixed[std::size_t(scene.bodies.wall().first) + i] != 0) led[i] = 0;
  const std::vector<Vec3>& x = scene.wall.solid.wall.vertices;
  scene.start.insert(scene.start.end(), x.begin() + std::ptrdiff_t(first), x.end());
  scene.mass.resize(std::size_t(scene.bodies.wall().first));
  scene.mass.insert(scene.mass.end(), scene.wall.solid.model.mass.begin(),
                    scene.wall.solid.model.mass.end());
  scene.fixed.resize(scene.start.size(), 0);
}

void add_rod(const SimulationModel& model, const GuidewireOptions& options, Scene& scene) {
  scene.rod = make_rod(model, options);
  scene.bodies[Body::guidewire] = {scene.vertex_count(), scene.rod.count};
  if (scene.rod.count == 0) return;
  scene.start.insert(scene.start.end(), model.guidewire.begin(), model.guidewire.end());
  scene.mass.insert(scene.mass.end(), scene.rod.mass.begin(), scene.rod.mass.end());
  scene.fixed.resize(scene.start.size(), 0);
}

// With a rod the neck is tied to it.
void add_slide(const SimulationModel& model, const GuidewireOptions& guidewire, Scene& scene) {
  if (guidewire.model == GuidewireModel::rod || model.guidewire.size() < 2) return;
  scene.slide.along = normalized(model.guidewire.back() - model.guidewire.end()[-2]);
  for (std::size_t v = 0; v < model.balloon_sliding.size(); ++v)
    if (model.balloon_sliding[v] != 0) scene.slide.vertices.push_back(int(v));
}

// Do layers of the membrane lie on each other? On the two sides of a tube they are a diameter
// apart.
bool starts_in_folds(const Scene& scene) {
  const TriangleMesh membrane{
      {scene.start.begin(), scene.start.begin() + scene.bodies.balloon().count},
      scene.balloon.triangles};
  double half_length = 0.0;
  for (const Vec3& p : membrane.vertices)
    half_length = std::max(half_length, norm(p - scene.origin));
  const double radius = std::sqrt(enclosed_volume(membrane) / (2.0 * units::kPi * half_length));
  return has_facing_layers(membrane, 0.5 * radius);
}

// Contact of the balloon with itself keeps gaps, it cannot make them.
void check_folds(const Scene& scene, double least_gap) {
  std::vector<Candidate> near;
  add_balloon_self_candidates(scene, scene.start, least_gap, near);
  if (near.empty() && self_crossing_count(scene.balloon.triangles, scene.start) == 0) return;
  throw InputError(
      "the balloon crosses or touches itself before it is inflated (contact of its folds cannot "
      "part them). Mesh again with another balloon.fold_gap_mm or balloon.folds, or use "
      "simulation.self_contact = false");
}

// A slack membrane folds where a bend or its wrinkles leave it too much length, and a wall where
// the balloon pushes it together. A taut balloon and its wall keep apart from themselves.
void add_self_contact(const SimulationOptions& options, Scene& scene) {
  if (!options.contact.self_contact || !pbd_policy(options).balances()) return;
  scene.balloon.has_folds = starts_in_folds(scene);
  if (!scene.balloon.has_folds &&
      !(scene.balloon.membrane.relaxed && scene.bodies.wall().count > 0))
    return;
  // Layers touch where their middles are a thickness apart.
  scene.self_distance = std::min(options.contact.distance_mm, scene.balloon.thickness);
  if (scene.balloon.has_folds) check_folds(scene, 2.0 * kLeastGap * options.contact.distance_mm);
}

Vec3 middle_of_box(const std::vector<Vec3>& points) {
  Vec3 low = points[0], high = points[0];
  for (const Vec3& p : points)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  return 0.5 * (low + high);
}

}  // namespace

Scene make_scene(const SimulationModel& given, const SimulationOptions& options) {
  check_model(given, options.wall);
  const Numbering balloon = number_vertices(given.balloon, given.balloon_fixed);
  const bool layered = !given.layered_wall.vertices.empty();
  if (layered) check_layered(given, options);
  const std::vector<char>& held = given.wall_fixed;
  const Numbering wall = layered
                             ? number_vertices(given.wall, held, patch_partners(given.layered_wall))
                             : number_vertices(given.wall, held);
  const SimulationModel model = renumbered(given, balloon, wall);
  Scene scene;
  scene.caller_vertex = balloon.order;
  scene.caller_vertex.insert(scene.caller_vertex.end(), wall.order.begin(), wall.order.end());
  scene.balloon.color_begin = balloon.begin;
  scene.wall.color_begin = wall.begin;
  for (int& v : scene.wall.color_begin) v += int(balloon.order.size());
  scene.air = model.air;
  scene.guidewire = model.guidewire;
  scene.bodies[Body::balloon] = {0, int(model.balloon.vertices.size())};
  scene.bodies[Body::wall] = {scene.bodies.balloon().end(), int(model.wall.vertices.size())};
  scene.start = model.balloon.vertices;
  scene.start.insert(scene.start.end(), model.wall.vertices.begin(), model.wall.vertices.end());
  scene.fixed = model.balloon_fixed;
  for (const int v : wall.order) scene.fixed.push_back(held[std::size_t(v)]);
  scene.mass.assign(scene.start.size(), 0.0);
  scene.origin = middle_of_box(model.balloon.vertices);
  add_balloon(model, options, scene);
  add_wall(model, options, scene);
  if (layered) add_solid(options, given, wall, scene);
  add_rod(model, options.guidewire, scene);
  add_slide(model, options.guidewire, scene);
  add_self_contact(options, scene);
  return scene;
}

}  // namespace angio::simulation::detail
