#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

/// Where the lumen is to be opened: the inlet first, then the outlets in path order.
struct LineEnd {
  Vec3 tip;             ///< end point of the line [mm]
  double radius = 0.0;  ///< of the lumen near the end [mm]
  int path = 0;
  bool at_inlet = false;
};
std::vector<LineEnd> line_ends(const CenterlineTree& tree);

/// The plane normal to the line at a distance [mm] inside its end; its normal leaves the lumen.
Plane plane_near_end(const CenterlineTree& tree, const LineEnd& end, double inset);

/// Distance inside the end at which the lumen has its full width [mm]: where the inscribed sphere
/// no longer shrinks into a rounded or blind tip, at least a quarter of a radius.
double full_width_inset(const CenterlineTree& tree, const LineEnd& end);

/// Cuts an open end: the triangles beyond the section of the plane around its origin go, and only
/// they; other branches that the plane meets stay whole.
///
/// @param rim         per vertex, -1 or the rim it belongs to; grows with the mesh
/// @param rim_index   given to the new rim's vertices
/// @param keep        a point of the lumen that must not be cut off, usually other line ends
/// @return false, with nothing changed, if the plane has no closed section there or would cut off
///         a part that is to be kept
bool open_end(TriangleMesh& mesh, std::vector<int>& rim, const Plane& plane, double radius,
              int rim_index, const std::vector<Vec3>& keep);

/// A copy closed by a flat cap over each rim, with one new vertex inside each cap.
struct CappedMesh {
  TriangleMesh mesh;
  std::vector<int> id;  ///< per vertex: 0 wall, rim index + 1 on caps and rims
};
CappedMesh cap_rims(const TriangleMesh& open, const std::vector<int>& rim);

}  // namespace angio::meshing::detail
