#include "simulation/pbd/tets.hpp"

#include <algorithm>
#include <set>

#include "core/error.hpp"
#include "core/tet_mesh.hpp"
#include "simulation/backends/state.hpp"
#include "simulation/bodies/element_colors.hpp"

namespace angio::simulation::detail {

bool projects_contact(const Scene& scene, const SimulationOptions& options) {
  return pbd_policy(options).contact && scene.bodies.wall().count > 0;
}

PbdTets pbd_tets(const Scene& scene, const SimulationOptions& options,
                 const std::vector<Tet>& air) {
  PbdTets result;
  for (Tet t : air) {
    const auto of_balloon = [&](int v) { return scene.bodies.of(v) == Body::balloon; };
    const auto corners = std::count_if(t.begin(), t.end(), of_balloon);
    if (*std::max_element(t.begin(), t.end()) >= scene.vertex_count()) continue;  // in the air
    if (corners == 0 || corners == 4) continue;
    bool even = true;
    for (std::size_t i = 0; i < 4; ++i)  // those of the balloon first
      for (std::size_t k = 3; k > i; --k)
        if (of_balloon(t[k]) && !of_balloon(t[k - 1])) {
          std::swap(t[k], t[k - 1]);
          even = !even;
        }
    if (!even)  // within a side the order is free
      corners == 1 ? std::swap(t[2], t[3]) : std::swap(t[0], t[1]);
    result.vertices.insert(result.vertices.end(), t.begin(), t.end());
    result.balloon_corners.push_back(int(corners));
  }
  if (air.empty())
    throw InputError(
        "contact.model paper needs an air mesh between balloon and wall, and there is none. Run "
        "the stage meshing again, or use contact.model barrier");
  const ElementColors colors = color_elements(result.vertices, 4, scene.vertex_count());
  result.vertices = in_order(colors, result.vertices, 4);
  result.balloon_corners = in_order(colors, result.balloon_corners);
  result.color_begin = colors.begin;
  for (std::size_t v = 0; v < scene.mass.size(); ++v)
    result.inverse_mass.push_back(scene.fixed[v] ? 0.0 : 1.0 / scene.mass[v]);
  double area = 0.0;
  for (const double a : scene.wall.area) area += a;
  const double face = area / double(scene.wall.triangles.size());
  const bool given = options.contact.paper_volume_2_mm3 > 0.0;
  result.volume_1 =
      given ? options.contact.paper_volume_1_mm3 : face * options.contact.adhesion_gap_1_mm / 3.0;
  result.volume_2 =
      given ? options.contact.paper_volume_2_mm3 : face * options.contact.adhesion_gap_2_mm / 3.0;
  return result;
}

std::vector<char> kept_items(const PbdTets& before, const std::vector<char>& triggered,
                             const PbdTets& now) {
  const auto corners = [](const PbdTets& tets, std::size_t t) {
    const int* v = &tets.vertices[4 * t];
    Tet sorted{v[0], v[1], v[2], v[3]};
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  };
  std::set<Tet> held;
  for (std::size_t t = 0; t < triggered.size(); ++t)
    if (triggered[t] != 0) held.insert(corners(before, t));
  std::vector<char> result;
  for (std::size_t t = 0; t < now.balloon_corners.size(); ++t)
    result.push_back(held.count(corners(now, t)) > 0 ? 1 : 0);
  return result;
}

PbdGasTets pbd_gas_tets(const Scene& scene) {
  if (scene.guidewire.empty())
    throw InputError(
        "simulation.gas_model per_tet needs a guidewire in the balloon, and there is none. Run the "
        "stage meshing again, or use simulation.gas_model = enclosed");
  PbdGasTets tets;
  tets.whole = balloon_volume(scene, scene.start);
  for (const Triangle& t : scene.balloon.triangles) {
    const Vec3 &a = scene.start[std::size_t(t[0])], &b = scene.start[std::size_t(t[1])],
               &c = scene.start[std::size_t(t[2])];
    const Vec3 middle = (a + b + c) / 3.0;
    const Vec3 apex = *std::min_element(
        scene.guidewire.begin(), scene.guidewire.end(),
        [&](const Vec3& p, const Vec3& q) { return distance(p, middle) < distance(q, middle); });
    const double volume = tet_volume(apex, a, b, c);
    if (!(volume > 1e-9 * tets.whole)) continue;
    tets.apex.push_back(apex);
    tets.triangles.insert(tets.triangles.end(), t.begin(), t.end());
    tets.volume.push_back(volume);
  }
  const ElementColors colors = color_elements(tets.triangles, 3, scene.bodies.balloon().count);
  tets.apex = in_order(colors, tets.apex);
  tets.triangles = in_order(colors, tets.triangles, 3);
  tets.volume = in_order(colors, tets.volume);
  tets.color_begin = colors.begin;
  return tets;
}

double mean_tet_pressure(const PbdGasTets& tets, double growth, double outside,
                         const std::vector<Vec3>& x) {
  double volume = 0.0, target = 0.0;
  for (std::size_t t = 0; t < tets.volume.size(); ++t) {
    const auto at = [&](std::size_t k) { return x[std::size_t(tets.triangles[3 * t + k])]; };
    volume += tet_volume(tets.apex[t], at(0), at(1), at(2));
    target += growth * tets.volume[t];
  }
  return outside * target / volume;
}

}  // namespace angio::simulation::detail
