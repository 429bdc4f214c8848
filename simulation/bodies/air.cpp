#include "simulation/bodies/air.hpp"

namespace angio::simulation::detail {

AdaptiveAir make_air(const SimulationModel& model, const Scene& scene) {
  const auto count = std::size_t(scene.bodies.surface_count());
  std::vector<Triangle> surfaces = scene.balloon_triangles;
  surfaces.insert(surfaces.end(), scene.wall_triangles.begin(), scene.wall_triangles.end());
  // In the caller's numbering of both surfaces, one after the other.
  std::vector<int> given(count), ours(count);
  for (std::size_t v = 0; v < count; ++v) {
    given[v] = scene.caller_vertex[v] + scene.bodies[scene.bodies.of(int(v))].first;
    ours[std::size_t(given[v])] = int(v);
  }
  AdaptiveAir::Rebuild rebuild;
  if (model.rebuild_air)
    rebuild = [mesh_again = model.rebuild_air, wall_begin = scene.bodies.wall().first, given,
               ours](const std::vector<Vec3>& x) {
      std::vector<Vec3> theirs(x.size());
      for (std::size_t v = 0; v < x.size(); ++v) theirs[std::size_t(given[v])] = x[v];
      const auto middle = theirs.begin() + wall_begin;
      TetMesh mesh = mesh_again({theirs.begin(), middle}, {middle, theirs.end()});
      for (Tet& t : mesh.tets)
        for (int& v : t)
          if (std::size_t(v) < ours.size()) v = ours[std::size_t(v)];
      if (!mesh.tets.empty()) std::copy(x.begin(), x.end(), mesh.vertices.begin());
      return mesh;
    };
  AdaptiveAir air(scene.air, {scene.start.begin(), scene.start.begin() + std::ptrdiff_t(count)},
                  std::move(surfaces), std::move(rebuild));
  if (model.rebuild_each_frame) air.rebuild_each_time();
  return air;
}

}  // namespace angio::simulation::detail
