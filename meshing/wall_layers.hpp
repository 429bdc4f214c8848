#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing {

/// What a wedge of the wall is made of, from the lumen outward but for the plaque, which lies
/// inside the intima, and for what of both is calcified.
enum class WallTissue { intima = 0, media = 1, adventitia = 2, plaque = 3, calcium = 4 };

struct WallLayerOptions {
  /// Wall thickness / outer diameter of the healthy vessel, [0.02, 0.4].
  double thickness_ratio = 0.189;
  /// Of intima, media and adventitia, each in (0, 1e3]; their sum counts as 1.
  std::array<double, 3> layer_fractions{0.27, 0.36, 0.40};
  int elements_per_layer = 1;  ///< wedges through intima, media and adventitia each, [1, 8]
  int plaque_elements = 2;     ///< wedges through the plaque, [2, 16]

  void validate() const;
};

/// Where the lumen is narrower than the healthy vessel, on a path of the tree.
struct NarrowStretch {
  int path_id = 0;
  double proximal_mm = 0.0, distal_mm = 0.0;  ///< abscissas of its edges
  double reference_diameter_mm = 0.0;         ///< of the healthy lumen
};

/// Of WallLayers::tissue_ratio: a wall that is thinner is as soft as it is thin.
inline constexpr double kMostTissueRatio = 20.0;

/// A wall of wedges (triangular prisms) around a lumen's surface.
struct WallLayers {
  /// [mm], shape [(element_layer_count + 1) * lumen_vertex_count]: the lumen's vertices, then the
  /// same ones further out, level by level.
  std::vector<Vec3> vertices;
  /// Corners: a triangle on the lumen's side, then the same one a level further out; the volume is
  /// positive. Level by level, each in the order of the lumen's triangles; over a triangle
  /// with a led vertex there is none.
  std::vector<std::array<int, 6>> wedges;
  std::vector<int> layer;          ///< of elements, 0 next to the lumen, shape [wedge_count]
  std::vector<WallTissue> tissue;  ///< shape [wedge_count]
  std::vector<Vec3> axial;         ///< unit, along the vessel away from the inlet, [wedge_count]
  /// Tissue that it stands for over its own volume, [1, 20]: the wanted length of its columns over
  /// the one that there is room for, in the mean; shape [wedge_count].
  std::vector<double> tissue_ratio;
  std::vector<Triangle> outer_triangles;  ///< normals leave the wall
  std::vector<char> fixed;                ///< as the region's, and led, shape [vertex_count]
  /// Without room for layers: the column goes with its neighbours, shape [lumen_vertex_count].
  std::vector<char> led;
  int lumen_vertex_count = 0;
  int element_layer_count = 0;
  std::vector<std::string> warnings;  ///< where the thickness was limited
};

/// Extrudes the lumen's surface to a wall of intima, media, adventitia and plaque.
///
///     thickness = 2 q / (1 - 2 q) R,   q = wall thickness / outer diameter, R the healthy radius
///
/// The outside of the wall is that of the healthy vessel: where the lumen is narrower, plaque fills
/// the space between it and the healthy lumen. Along a stretch the healthy radius is at least the
/// reference's and the healthy axis is the line's course without the lesion; elsewhere both are the
/// line's own. Every wedge is right-handed at its six corners, and the outside does not cross
/// itself; where that needs a thinner wall (in creases at branches), its wedges stand for more
/// tissue than they are (tissue_ratio), and a warning says so. Where a quarter of the thickness is
/// still too much, and at the tips of flaps beside such places, there are no layers and the wall is
/// led: it goes with what is around it.
///
/// Where the lumen does not lie around its lines, its own width gives the thickness.
///
/// Source: Holzapfel, Sommer, Gasser, Regitnig, Am. J. Physiol. 289 (2005) H2048: wall thickness /
///         outer diameter 0.189 +- 0.014, and the layers' shares
/// @param region    the lumen's surface; its vertices are the first of the result
/// @param tree      lines of the lumen
/// @param stretches narrow ones; none: no plaque
/// @throws InputError if there is no room for layers anywhere
WallLayers build_wall_layers(const ContactRegion& region, const CenterlineTree& tree,
                             const std::vector<NarrowStretch>& stretches,
                             const WallLayerOptions& options);

/// The least determinant of a wedge's edges at its six corners [mm^3]; positive if it is
/// right-handed everywhere.
double least_corner_determinant(const std::vector<Vec3>& vertices, const std::array<int, 6>& wedge);

}  // namespace angio::meshing
