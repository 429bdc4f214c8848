#include "simulation/bodies/air.hpp"

#include "air_mesh/build/build_air.hpp"

namespace angio::simulation::detail {
namespace {

/// Builds the air of a scene where the surfaces are now.
class SceneAirBuilder {
 public:
  SceneAirBuilder(const SimulationModel& model, const Scene& scene)
      : balloon_(model.balloon.triangles), wall_(model.wall.triangles) {
    const auto count = std::size_t(scene.bodies.surface_count());
    balloon_count_ = std::size_t(scene.bodies.wall().first);
    given_.resize(count);
    ours_.resize(count);
    for (std::size_t v = 0; v < count; ++v) {
      given_[v] = scene.caller_vertex[v] + scene.bodies[scene.bodies.of(int(v))].first;
      ours_[std::size_t(given_[v])] = int(v);
    }
  }

  TetMesh operator()(const std::vector<Vec3>& x) const {
    std::vector<Vec3> theirs(x.size());
    for (std::size_t v = 0; v < x.size(); ++v) theirs[std::size_t(given_[v])] = x[v];
    const auto middle = theirs.begin() + std::ptrdiff_t(balloon_count_);
    TetMesh mesh =
        air_mesh::build_air({{theirs.begin(), middle}, balloon_}, {{middle, theirs.end()}, wall_});
    for (Tet& t : mesh.tets)
      for (int& v : t)
        if (std::size_t(v) < ours_.size()) v = ours_[std::size_t(v)];
    if (!mesh.tets.empty()) std::copy(x.begin(), x.end(), mesh.vertices.begin());
    return mesh;
  }

 private:
  std::vector<Triangle> balloon_, wall_;  ///< in the caller's numbering of each
  std::size_t balloon_count_ = 0;         ///< vertices
  std::vector<int> given_;  ///< of the scene's vertices, in the caller's numbering of both surfaces
  std::vector<int> ours_;   ///< the other way
};

}  // namespace

air_mesh::AdaptiveAir make_air(const SimulationModel& model, const Scene& scene) {
  const auto count = std::size_t(scene.bodies.surface_count());
  std::vector<Triangle> surfaces = scene.balloon.triangles;
  surfaces.insert(surfaces.end(), scene.wall.triangles.begin(), scene.wall.triangles.end());
  air_mesh::AirMesher mesher;
  if (!scene.air.empty() && air_mesh::can_build_air())
    mesher = {SceneAirBuilder(model, scene), air_mesh::mesh_hollow};
  air_mesh::AdaptiveAir air(scene.air,
                            {scene.start.begin(), scene.start.begin() + std::ptrdiff_t(count)},
                            std::move(surfaces), std::move(mesher));
  if (model.rebuild_each_frame) air.rebuild_each_time();
  return air;
}

}  // namespace angio::simulation::detail
