#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "meshing/detail/edge_lengths.hpp"
#include "meshing/detail/isosurface.hpp"
#include "meshing/detail/lumen_draft.hpp"
#include "meshing/detail/open_ends.hpp"
#include "meshing/detail/remesh.hpp"
#include "meshing/detail/surface_query.hpp"
#include "meshing/detail/surface_target.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing {
namespace {

using detail::LineEnd;
using detail::SurfaceDraft;
using detail::SurfaceTarget;

void check_tree(const CenterlineTree& tree) {
  if (tree.paths.empty())
    throw InputError(
        "the centreline has no line (nothing says which lumen to mesh). Run the stage "
        "centerline again");
}

/// Halves the wanted lengths around triangles that cross.
void refine_around(SurfaceDraft& draft, const std::vector<std::array<int, 2>>& pairs) {
  std::vector<char> near(draft.mesh.vertices.size(), 0);
  for (const auto& pair : pairs)
    for (const int t : pair)
      for (const int v : draft.mesh.triangles[std::size_t(t)]) near[std::size_t(v)] = 1;
  const auto neighbors = vertex_neighbors(draft.mesh);
  for (int ring = 0; ring < 3; ++ring) {
    const std::vector<char> before = near;
    for (std::size_t v = 0; v < near.size(); ++v)
      for (const int u : neighbors[v]) near[v] |= before[std::size_t(u)];
  }
  for (std::size_t v = 0; v < near.size(); ++v)
    if (near[v]) draft.edge_length[v] *= 0.5;
  detail::limit_growth(draft.mesh, draft.edge_length);
}

/// Remeshes, smooths and balances; where triangles cross, tries again with finer ones.
void improve_surface(SurfaceDraft& draft, const SurfaceTarget& target,
                     const LumenMeshOptions& options, const Progress& progress) {
  constexpr int kRounds = 6;
  constexpr int kAttempts = 5;
  detail::remesh(draft, target, kRounds);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    progress.report(0.6 + 0.3 * attempt / kAttempts, "smoothing");
    SurfaceDraft smoothed = draft;
    const double share = attempt < 2 ? 1.0 : attempt == 2 ? 0.5 : 0.0;
    detail::smooth(smoothed, int(std::lround(share * options.smoothing_iterations)));
    if (attempt < kAttempts - 1) detail::balance_volume(smoothed, target);
    const auto pairs = detail::self_intersections(smoothed.mesh);
    if (pairs.empty()) {
      draft = std::move(smoothed);
      return;
    }
    refine_around(smoothed, pairs);
    draft.edge_length = smoothed.edge_length;
    detail::remesh(draft, target, 2);
  }
  throw InternalError(
      "the lumen's surface still crosses itself after " + std::to_string(kAttempts) +
      " attempts (vessels that touch each other, or noise). Smooth the segmentation or mesh with "
      "shorter edges (meshing.edges_per_circumference)");
}

LumenMesh finish(SurfaceDraft draft, std::vector<std::string> warnings) {
  LumenMesh result;
  result.open = std::move(draft.mesh);
  detail::CappedMesh capped = detail::cap_rims(result.open, draft.rim);
  result.capped = std::move(capped.mesh);
  result.inlet_outlet_id = std::move(capped.id);
  const SurfaceTopology topology = surface_topology(result.capped);
  result.watertight = topology.is_closed() && topology.component_count == 1;
  result.self_intersection_count = int(detail::self_intersections(result.capped).size());
  result.min_angle_degrees = 180.0;
  for (const Triangle& t : result.open.triangles)
    result.min_angle_degrees =
        std::min(result.min_angle_degrees,
                 detail::least_angle_degrees(result.open.vertices[std::size_t(t[0])],
                                             result.open.vertices[std::size_t(t[1])],
                                             result.open.vertices[std::size_t(t[2])]));
  if (!result.watertight) throw InternalError("the capped lumen is not watertight");
  if (result.self_intersection_count > 0)
    throw InternalError("a cap of the lumen crosses its wall (" +
                        std::to_string(result.self_intersection_count) + " pairs of triangles)");
  result.warnings = std::move(warnings);
  return result;
}

/// Wanted edges are not made much shorter than what the data can show.
double least_edge_length(const VolumeGeometry& grid) {
  return 0.35 * std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
}

}  // namespace

LumenMesh mesh_lumen(const Volume<float>& level_set, const CenterlineTree& tree,
                     const LumenMeshOptions& options, const Progress& progress) {
  options.validate();
  check_tree(tree);
  progress.report(0.0, "isosurface");
  const Volume<float> padded = detail::pad_level_set(level_set);
  const detail::LevelSetTarget target(padded);
  SurfaceDraft draft;
  std::vector<std::string> warnings;
  draft.mesh = detail::component_of_lines(detail::extract_isosurface(padded), tree);
  draft.rim.assign(draft.mesh.vertices.size(), -1);
  progress.report(0.1, "opening the ends");
  detail::open_ends(draft, tree, detail::line_ends(tree), warnings);
  detail::set_edge_lengths(draft, tree, options, least_edge_length(padded.geometry), warnings);
  progress.report(0.2, "remeshing");
  improve_surface(draft, target, options, progress);
  progress.report(0.9, "caps and checks");
  LumenMesh result = finish(std::move(draft), std::move(warnings));
  progress.report(1.0);
  return result;
}

LumenMesh mesh_lumen(const TriangleMesh& surface, const CenterlineTree& tree,
                     const LumenMeshOptions& options, const Progress& progress) {
  options.validate();
  check_tree(tree);
  progress.report(0.0, "repairing the surface");
  std::vector<std::string> warnings;
  const std::vector<LineEnd> ends = detail::line_ends(tree);
  SurfaceDraft draft = detail::repaired_draft(surface, tree, ends);
  const TriangleMesh original = draft.mesh;
  const detail::MeshTarget target(original);
  progress.report(0.1, "opening the ends");
  detail::open_ends(draft, tree, ends, warnings);
  // A given surface may have long triangles, which do not show where the lumen is narrow: the
  // lengths are set again once there are vertices everywhere.
  std::vector<std::string> first_warnings;
  detail::set_edge_lengths(draft, tree, options, 0.0, first_warnings);
  progress.report(0.2, "remeshing");
  detail::remesh(draft, target, 2);
  detail::set_edge_lengths(draft, tree, options, 0.0, warnings);
  improve_surface(draft, target, options, progress);
  progress.report(0.9, "caps and checks");
  LumenMesh result = finish(std::move(draft), std::move(warnings));
  progress.report(1.0);
  return result;
}

int count_self_intersections(const TriangleMesh& mesh) {
  return int(detail::self_intersections(mesh).size());
}

int count_intersections(const TriangleMesh& mesh_a, const TriangleMesh& mesh_b) {
  return int(detail::intersections(mesh_a, mesh_b).size());
}

}  // namespace angio::meshing
