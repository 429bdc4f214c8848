#pragma once

#include <memory>
#include <vector>

#include "centerline/centerline.hpp"
#include "core/volume.hpp"

namespace angio::centerline {

/// What the data that a lumen was found in can show: a scan by its voxels, a surface by its
/// triangles, and by the voxels that it was made from where it shows them.
struct Resolution {
  double longest_mm = 0.0;  ///< edge of a voxel. Narrower throats are seen, but not measured
  double mean_mm = 0.0;     ///< edge of a cube of a voxel's volume
  std::shared_ptr<const TriangleMesh> surface;  ///< null: a scan
  /// LPS [mm], where the segmentation kept open what is narrower than the scan can show.
  std::vector<Vec3> narrow_lps_mm = {};
  std::shared_ptr<const Volume<float>> scan = nullptr;  ///< null: a surface, or labels
};

/// Whether a lesion's throat is seen, but its diameter not measured: it is narrower than a voxel,
/// or the segmentation kept the vessel open between the lesion's edges, or half a reference
/// diameter beside them.
bool is_unmeasured(const Lesion& lesion, const CenterlinePath& path, const Resolution& resolution);

/// Of voxels of a size [mm].
Resolution resolution_of_voxels(const Vec3& spacing);
/// Of voxels of a label map, which has nothing between inside and outside: it shows half as much.
Resolution resolution_of_labels(const Vec3& spacing);
/// Of a surface. Voxels are told by the grid that its vertices keep to (detail/lattice.hpp).
Resolution resolution_of_surface(TriangleMesh surface);

/// The settings for lesions, with what the data can show.
LesionOptions lesion_options(LesionOptions options, const Resolution& resolution);

/// The same for the whole tree, wherever the settings want to look.
LesionOptions whole_tree(LesionOptions options);

/// The edge [mm] of a surface's triangles around a place: the median of their mean edges within
/// `reach` [mm], or that of the nearest triangle. 0: no triangles.
double edge_around(const TriangleMesh& surface, const Vec3& place, double reach);

}  // namespace angio::centerline
