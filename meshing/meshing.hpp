#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"

namespace angio::meshing {

struct LumenMeshOptions {
  double edge_length_mm = 0.0;            ///< target, (0, 5]; 0: by the local radius
  double edges_per_circumference = 16.0;  ///< where edge_length_mm is 0, [8, 64]
  int triangle_budget = 200000;  ///< upper bound, [1000, 5e6]; edges are lengthened to keep it
  /// Exact number of triangles, 0 or [1000, 1e6], even: edges are scaled to it. The outlets are
  /// then closed by caps, and the inlet by one with an octagonal opening, which counts as a part of
  /// the open lumen; see detail/fixed_count.hpp. 0: by the edge lengths.
  int triangle_count = 0;
  bool keep = false;  ///< a given surface's triangles are kept; it must be open at its ends
  double smoothing_iterations = 10;  ///< volume-keeping smoothing, [0, 100]
  double extension_diameters = 0.0;  ///< straight tubes on the inlet and outlets, [0, 20]; 0: none

  void validate() const;
};

/// A stretch of a path that a balloon will widen.
struct WidenedStretch {
  int path_id = 0;
  double proximal_mm = 0.0, distal_mm = 0.0;  ///< abscissas of its ends
  double diameter_mm = 0.0;                   ///< that the lumen will have
};

/// What the open lumen is like, before extensions.
struct LumenQuality {
  int triangle_count = 0;
  int vertex_count = 0;
  double area_mm2 = 0.0;
  double volume_mm3 = 0.0;                  ///< between the rims
  double min_angle_degrees = 0.0;           ///< of a triangle
  double min_angle_off_rims_degrees = 0.0;  ///< of a triangle without a rim's vertex
  double angle_percentile_1_degrees = 0.0;  ///< of the triangles' least angles
  double angle_median_degrees = 0.0;
  std::array<int, 12> angle_histogram{};  ///< triangles with a least angle from 5 i to 5 i + 5
  int below_20_degrees = 0;               ///< triangles off the rims
  int below_20_degrees_at_rims = 0;
  double edge_min_mm = 0.0;
  double edge_mean_mm = 0.0;
  double edge_max_mm = 0.0;
  double distance_mean_mm = 0.0;  ///< from the level set's zero (from the given surface if there is
                                  ///< one), of vertices and middles of triangles
  double distance_percentile_95_mm = 0.0;
  double distance_max_mm = 0.0;
  double volume_change_mm3 = 0.0;  ///< volume more than that of the level set's zero
  double volume_change_percent = 0.0;
};

struct LumenMesh {
  TriangleMesh open;    ///< open at the inlet and outlets, planar rims
  TriangleMesh capped;  ///< watertight; vertices and triangles of `open`, then those of the caps
  /// Per vertex of `capped`: 0 wall, 1 inlet, 2... outlets in path order. A rim's vertices carry
  /// the id of its cap: a triangle is of a cap exactly if its corners carry the same id above 0.
  /// With a fixed count of triangles, caps are in `open`, too.
  std::vector<int> inlet_outlet_id;
  bool watertight = false;                ///< of `capped`
  int self_intersection_count = 0;        ///< pairs of triangles
  double min_angle_degrees = 0.0;         ///< least angle of a triangle of `open`
  double capped_min_angle_degrees = 0.0;  ///< the same of `capped`
  int capped_below_20_degrees = 0;        ///< triangles of `capped` with a least angle below
  LumenQuality quality;
  std::vector<std::string> warnings;
};

/// The lumen's surface, remeshed, from its level set or from a given surface.
///
/// @param widened  stretches whose triangles are longer along the vessel than around, half way to
///                 what they would have to be to come out equilateral when widened; not where
///                 `options` ask for a length or a count
LumenMesh mesh_lumen(const Volume<float>& level_set, const CenterlineTree& tree,
                     const LumenMeshOptions& options, const Progress& progress = {},
                     const std::vector<WidenedStretch>& widened = {});
LumenMesh mesh_lumen(const TriangleMesh& surface, const CenterlineTree& tree,
                     const LumenMeshOptions& options, const Progress& progress = {},
                     const std::vector<WidenedStretch>& widened = {});

/// How a balloon's cylinder ends.
enum class BalloonEnds {
  cones,        ///< in necks on the shaft; the distal one slides along the wire
  hemispheres,  ///< the seed paper's
};

struct BalloonOptions {
  double nominal_diameter_mm = 0.0;  ///< [0.5, 30]; 0: the reference diameter, to the next 0.25 mm
  /// Of the unloaded balloon, [0.5, 30]; 0: the nominal one. A balloon with a compliance chart is
  /// smaller when empty.
  double rest_diameter_mm = 0.0;
  /// Of the cylindrical part, [2, 80]; 0: over the lesion by 3 mm each side, as far as balloons of
  /// the diameter are sold, shorter where the vessel turns by more than 90 degrees along it.
  double length_mm = 0.0;
  /// Crossing profile, [0.3, 30]; 0: 0.9 mm up to a diameter D of 4 mm, above it times (D / 4)^2/3;
  /// less where it must pass.
  double start_diameter_mm = 0.0;
  BalloonEnds ends = BalloonEnds::hemispheres;
  int ring_count = 26;            ///< rings of vertices, [6, 400]; 26 x 20 + 2 = the paper's 522
  int ring_vertex_count = 20;     ///< vertices a ring, [6, 200]
  int guidewire_node_count = 24;  ///< [2, 1000]
  /// Flaps wrapped around the shaft at the start, {0, 2, 3, 5}; 0: a tube of the start diameter,
  /// whose folds are not meshed. Folds need more vertices: the ring counts are then the least.
  int folds = 0;
  double shaft_diameter_mm = 0.6;  ///< of the shaft inside the folds, [0.2, 10]
  double fold_gap_mm = 0.02;  ///< between layers, at least the membrane's thickness, [0.005, 0.5]

  void validate() const;
};

struct Balloon {
  TriangleMesh start;  ///< closed, on the guidewire inside the lumen; poles are the last 2 vertices
  /// Unloaded shape: straight, of the rest diameter, shape [vertex_count]. Folded, the edges of
  /// the cylinder's rings are as long at the start, and every crease is one of its meridians.
  std::vector<Vec3> rest;
  std::vector<char> fixed;  ///< tied to the shaft: the poles, necks, rings no wider than the shaft
  std::vector<char> sliding;    ///< of the fixed ones: the distal neck, which slides along the wire
  std::vector<Vec3> guidewire;  ///< nodes from pole to pole
  /// Its nodes along the vessel on the inlet's side and on the other one, from the near end to the
  /// tip, without the poles; where the line ends there, fewer or none.
  std::vector<Vec3> guidewire_before, guidewire_behind;
  double nominal_diameter_mm = 0.0;
  double length_mm = 0.0;
  double start_diameter_mm = 0.0;
  double shaft_diameter_mm = 0.0;  ///< inside the folds; 0 unfolded
  int fold_count = 0;
  int ring_count = 0;
  int ring_vertex_count = 0;
};

/// The part of the wall that the balloon can touch.
struct ContactRegion {
  TriangleMesh mesh;              ///< open; oriented as the lumen (normals leave the lumen)
  std::vector<int> lumen_vertex;  ///< index in the open lumen mesh, shape [vertex_count]
  std::vector<char> fixed;        ///< do not move: on the boundary, and far from the balloon
  std::vector<double> abscissa;   ///< of the nearest point of the lesion's path [mm]
  std::vector<int> group;         ///< GroupIds of the branch the vertex belongs to
};

struct AirMesh {
  TetMesh tets;  ///< vertices: the balloon's, then the region's; no others; every tet positive
};

struct BalloonSetup {
  Balloon balloon;
  ContactRegion region;
  AirMesh air;
  std::vector<std::string> warnings;
};

/// The nominal diameter [mm] of the balloon for a vessel, where none is given: the reference
/// diameter, to the next 0.25 mm in which balloons are sold, at least 1 mm.
double usual_balloon_diameter_mm(double reference_diameter_mm);

/// Its length [mm] where none is given: over the lesion by 3 mm each side, no shorter than wide,
/// and no longer than balloons of the diameter are sold.
double usual_balloon_length_mm(double lesion_length_mm, double nominal_diameter_mm);

/// The length of the shortest balloons sold in a diameter [mm]: they are at least as long as wide.
double shortest_balloon_length_mm(double diameter_mm);

/// The least diameter of a lumen [mm] that a balloon crosses, whatever its profile: the thinnest
/// start shape and the gap around it.
double least_lumen_to_cross_mm();

/// Places the balloon across a lesion and meshes the gap to the wall that it can touch.
///
/// @param path           the line that the guidewire follows
/// @param abscissa_mm    of the lesion's tightest place
/// @param lesion_length_mm, reference_diameter_mm   of the lesion
/// @throws InputError if no balloon fits there
BalloonSetup place_balloon(const LumenMesh& lumen, const CenterlineTree& tree,
                           const CenterlinePath& path, double abscissa_mm, double lesion_length_mm,
                           double reference_diameter_mm, const BalloonOptions& options,
                           const Progress& progress = {});

/// Pairs of triangles that cross: within one surface (those that share a vertex are left out), and
/// between two.
int count_self_intersections(const TriangleMesh& mesh);
int count_intersections(const TriangleMesh& mesh_a, const TriangleMesh& mesh_b);

}  // namespace angio::meshing
