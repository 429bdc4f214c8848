#pragma once

#include <array>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "simulation/bodies/body_ranges.hpp"
#include "simulation/bodies/guidewire.hpp"
#include "simulation/bodies/layered_wall.hpp"
#include "simulation/bodies/wall_slabs.hpp"
#include "simulation/materials/membrane.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

using Edge = std::array<int, 2>;

/// One triangle seen from one of its corners.
struct Corner {
  int next = 0, last = 0;      ///< the other corners, counter-clockwise
  CornerMetric<double> rest;   ///< of the unloaded shape: the membrane
  CornerMetric<double> start;  ///< of the start shape: the folds
};

/// The balloon's constants; its vertices are the scene's first.
struct SceneBalloon {
  std::vector<Triangle> triangles;
  std::vector<Edge> edges;
  std::vector<int> color_begin;   ///< vertex, shape [color_count + 1]
  std::vector<int> corner_begin;  ///< shape [balloon vertex + 1]
  std::vector<Corner> corners;
  MembraneLaw<double> membrane;  ///< [Pa]
  MooneyRivlin<double> folds;    ///< [Pa]; zero when the membrane needs no help
  double thickness = 0.0;        ///< of the membrane, H [mm]
  double rest_radius = 0.0;      ///< of a tube of the rest shape's volume and area [mm]
  bool has_folds = false;        ///< layers of the balloon lie on each other at the start
};

/// The balloon's distal neck, where it slides along the wire.
struct SceneSlide {
  std::vector<int> vertices;  ///< of the balloon; none: it is held
  Vec3 along;                 ///< unit: the direction in which the guidewire ends
};

/// The wall's constants, of either model.
struct SceneWall {
  std::vector<Triangle> triangles;  ///< of its lumen
  std::vector<Edge> edges;
  std::vector<int> color_begin;     ///< vertex, shape [color_count + 1]
  std::vector<int> neighbor_begin;  ///< shape [wall vertex + 1]
  std::vector<int> neighbors;       ///< vertex numbers
  std::vector<double> foundation;   ///< [uN/mm], shape [wall vertex]
  std::vector<double> area;         ///< [mm^2] at the start, shape [wall vertex]
  WallSlabs slabs;
  WallSolid solid;  ///< of a layered wall; without one it has no levels
};

/// All that does not change during a run. Vertices are numbered balloon first, then wall, each
/// surface as in numbering.hpp: colour by colour, then those that do not move; at last the
/// guidewire's nodes. A layered wall's copies further out follow the wall, level by level.
struct Scene {
  BodyRanges bodies;
  std::vector<Vec3> start;         ///< [mm], shape [vertex]
  std::vector<char> fixed;         ///< shape [vertex]
  std::vector<double> mass;        ///< [g], shape [vertex]
  std::vector<int> caller_vertex;  ///< of a vertex of the balloon or the wall, in the caller's
                                   ///< numbering of that surface, shape [vertex]
  Vec3 origin;                     ///< the middle of the balloon's box at the start [mm]
  SceneBalloon balloon;
  SceneSlide slide;
  SceneWall wall;
  std::vector<Tet> air;
  std::vector<Vec3> guidewire;  ///< nodes as they are given
  SceneRod rod;                 ///< the guidewire; its nodes are the last vertices
  /// Contact of balloon and wall, each with itself, acts below this gap [mm]; 0: it is not looked
  /// for.
  double self_distance = 0.0;

  [[nodiscard]] int vertex_count() const { return int(start.size()); }
};

/// @throws InputError if shapes do not match, the balloon is not closed, or a triangle is flat
Scene make_scene(const SimulationModel& model, const SimulationOptions& options);

}  // namespace angio::simulation::detail
