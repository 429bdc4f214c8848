#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "air_mesh/build/surface_crossings.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "meshing/detail/cap_rims.hpp"
#include "meshing/detail/crossings.hpp"
#include "meshing/detail/edge_lengths.hpp"
#include "meshing/detail/extend_rims.hpp"
#include "meshing/detail/fixed_count.hpp"
#include "meshing/detail/isosurface.hpp"
#include "meshing/detail/lumen_draft.hpp"
#include "meshing/detail/mesh_quality.hpp"
#include "meshing/detail/open_ends.hpp"
#include "meshing/detail/remesh.hpp"
#include "meshing/detail/remesh_caps.hpp"
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
  for (const CenterlinePath& path : tree.paths)
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const Vec3& p = path.points[i];
      if (!std::isfinite(p.x + p.y + p.z + path.abscissa[i] + path.inscribed_radius[i]))
        throw InputError("line " + std::to_string(path.id) +
                         " of the centreline has a place or a radius that is not a number (point " +
                         std::to_string(i) + "). Run the stage centerline again");
    }
}

/// Remeshes, smooths and balances; where triangles cross, the surface is cut out and closed anew.
///
/// @param tolerance  [mm] smoothing leaves the surface within this distance of the target
void improve_surface(SurfaceDraft& draft, const SurfaceTarget& target, double tolerance,
                     const LumenMeshOptions& options, const Progress& progress,
                     std::vector<std::string>& warnings) {
  constexpr int kRounds = 6;
  detail::remesh(draft, target, kRounds);
  progress.report(0.6, "smoothing");
  detail::smooth(draft, target, int(std::lround(options.smoothing_iterations)), tolerance);
  progress.report(0.75, "looking for crossings");
  constexpr int kPasses = 3;
  int closed_count = 0;
  std::vector<std::array<int, 2>> poor;
  for (int pass = 0; pass < kPasses; ++pass) {
    closed_count += detail::resolve_crossings(draft, target, poor);
    poor = detail::improve_angles(draft, target);
    const auto at_caps = detail::faults_of_caps(draft);
    poor.insert(poor.end(), at_caps.begin(), at_caps.end());
    if (poor.empty()) break;
  }
  closed_count += detail::close_openings(draft);
  detail::bring_membranes_back(draft, target);
  if (closed_count > 0)
    warnings.push_back("at " + std::to_string(closed_count) + " places finer than the " +
                       target.source() +
                       " can show, the lumen's surface crossed itself and was closed again");
}

/// The wall with exactly the triangles asked for, less those of the caps to come.
void fit_triangle_count(SurfaceDraft& draft, const SurfaceTarget& target, double tolerance,
                        const LumenMeshOptions& options, std::vector<std::string>& warnings) {
  constexpr int kAttempts = 4;
  constexpr double kNear = 0.01;  // of the triangles may be split or collapsed one by one
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const int wanted = options.triangle_count - detail::closing_triangle_count(draft.mesh);
    const double ratio = double(draft.mesh.triangles.size()) / wanted;
    if (std::abs(ratio - 1.0) < kNear) break;
    for (double& length : draft.edge_length) length *= std::sqrt(ratio);
    improve_surface(draft, target, tolerance, options, {}, warnings);
  }
  detail::fit_count(draft, target,
                    options.triangle_count - detail::closing_triangle_count(draft.mesh));
  if (!air_mesh::self_intersections(draft.mesh).empty())
    throw InputError(
        "the lumen crosses itself with so few triangles. Raise or leave out mesh.triangle_count");
}

std::set<int> rims_of(const SurfaceDraft& draft) {
  std::set<int> rims(draft.rim.begin(), draft.rim.end());
  rims.erase(-1);
  return rims;
}

/// The wall with triangles as they are asked for. Ends that were too fine to stay open are told of.
void shape_surface(SurfaceDraft& draft, const SurfaceTarget& target, double tolerance,
                   const LumenMeshOptions& options, const Progress& progress,
                   std::vector<std::string>& warnings) {
  const std::set<int> before = rims_of(draft);
  improve_surface(draft, target, tolerance, options, progress, warnings);
  if (options.triangle_count > 0) fit_triangle_count(draft, target, tolerance, options, warnings);
  const std::set<int> after = rims_of(draft);
  std::vector<std::string> lost;
  for (const int rim : before)
    if (!after.contains(rim)) lost.push_back(detail::name_of_end(rim));
  if (!lost.empty())
    warnings.push_back(
        "these ends of lines stay closed, because the lumen there is finer than the " +
        target.source() + " can show: " + list_a_few(lost, "ends"));
}

void measure_least_angles(LumenMesh& lumen) {
  constexpr double kPoor = 20.0;
  lumen.min_angle_degrees = lumen.capped_min_angle_degrees = 180.0;
  for (std::size_t t = 0; t < lumen.capped.triangles.size(); ++t) {
    const auto corner = [&](std::size_t c) {
      return lumen.capped.vertices[std::size_t(lumen.capped.triangles[t][c])];
    };
    const double angle = detail::least_angle_degrees(corner(0), corner(1), corner(2));
    lumen.capped_min_angle_degrees = std::min(lumen.capped_min_angle_degrees, angle);
    if (angle < kPoor) ++lumen.capped_below_20_degrees;
    if (t < lumen.open.triangles.size())
      lumen.min_angle_degrees = std::min(lumen.min_angle_degrees, angle);
  }
}

/// A mesh that came out unsound. Triangles too large for the vessel, which the user may ask for,
/// are no mistake of ours.
[[noreturn]] void refuse(const std::string& fault, const LumenMeshOptions& options) {
  if (options.edge_length_mm > 0.0)
    throw InputError(fault +
                     " (the vessel is likely too narrow for edges so long). Lower or leave out "
                     "mesh.edge_length_mm");
  if (options.triangle_count > 0)
    throw InputError(fault +
                     " (there are likely too few triangles). Raise or leave out "
                     "mesh.triangle_count");
  throw InternalError(fault);
}

LumenMesh finish(SurfaceDraft draft, const SurfaceTarget& target, const LumenMeshOptions& options,
                 std::vector<std::string> warnings) {
  LumenMesh result;
  const int vessels = surface_topology(draft.mesh).component_count;
  result.quality = detail::measure_quality(draft, target);
  detail::set_volume(result.quality, detail::cap_rims(draft.mesh, draft.rim).mesh);
  detail::extend_rims(draft, options.extension_diameters, warnings);
  result.open = std::move(draft.mesh);
  detail::CappedMesh capped = detail::cap_rims(result.open, draft.rim);
  // A fixed count of triangles includes those of the caps.
  if (options.triangle_count == 0 && !options.keep)
    capped = detail::remesh_caps(result.open, capped);
  result.capped = std::move(capped.mesh);
  result.inlet_outlet_id = std::move(capped.id);
  if (options.triangle_count > 0) detail::close_but_inlet(result);
  const SurfaceTopology topology = surface_topology(result.capped);
  result.watertight = topology.is_closed() && topology.component_count == vessels;
  result.self_intersection_count = int(air_mesh::self_intersections(result.capped).size());
  measure_least_angles(result);
  if (!result.watertight) refuse("the capped lumen is not watertight", options);
  if (result.self_intersection_count > 0)
    refuse("a cap of the lumen crosses its wall, at " +
               std::to_string(result.self_intersection_count) + " pairs of triangles",
           options);
  result.warnings = std::move(warnings);
  return result;
}

/// Who asks for a length or a count of his own gets even triangles.
detail::Widening widening_for(const LumenMeshOptions& options, const CenterlineTree& tree,
                              const std::vector<WidenedStretch>& widened) {
  const bool is_by_radius = options.edge_length_mm == 0.0 && options.triangle_count == 0;
  return is_by_radius ? detail::Widening(tree, widened) : detail::Widening();
}

double shortest_spacing(const VolumeGeometry& grid) {
  return std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
}
constexpr double kLeastEdge = 0.35;  // voxels; shorter edges would follow noise
constexpr double kTolerance = 0.2;   // voxels that smoothing may move the surface

/// A surface that is open at the lines' ends, as it is.
LumenMesh keep_surface(const TriangleMesh& surface, const CenterlineTree& tree,
                       const LumenMeshOptions& options) {
  SurfaceDraft draft;
  draft.mesh = surface;
  draft.rim.assign(surface.vertices.size(), -1);
  draft.membrane.assign(surface.vertices.size(), 0);
  const std::vector<LineEnd> ends = detail::line_ends(tree);
  const auto loops = boundary_loops(surface);
  for (const std::vector<int>& loop : loops) {
    Vec3 middle;
    for (const int v : loop) middle += surface.vertices[std::size_t(v)] / double(loop.size());
    const auto nearest =
        std::min_element(ends.begin(), ends.end(), [&](const auto& a, const auto& b) {
          return distance(a.tip, middle) < distance(b.tip, middle);
        });
    for (const int v : loop) draft.rim[std::size_t(v)] = int(nearest - ends.begin());
  }
  if (loops.size() != ends.size() || surface_topology(surface).nonmanifold_edge_count > 0)
    throw InputError("the given surface cannot be kept as it is (it has " +
                     std::to_string(loops.size()) + " open ends where its lines have " +
                     std::to_string(ends.size()) + "). Leave out mesh.keep");
  for (const LineEnd& end : ends)
    draft.rim_planes.push_back(detail::plane_near_end(tree, end, 0.0));
  return finish(std::move(draft), detail::MeshTarget(surface), options, {});
}

}  // namespace

LumenMesh mesh_lumen(const Volume<float>& level_set, const CenterlineTree& tree,
                     const LumenMeshOptions& options, const Progress& progress,
                     const std::vector<WidenedStretch>& widened) {
  options.validate();
  check_tree(tree);
  progress.report(0.0, "isosurface");
  const Volume<float> padded = detail::pad_level_set(level_set);
  const detail::LevelSetTarget target(padded);
  const detail::Widening widening = widening_for(options, tree, widened);
  SurfaceDraft draft;
  draft.widening = &widening;
  std::vector<std::string> warnings;
  draft.mesh = detail::components_of_lines(detail::extract_isosurface(padded), tree);
  draft.rim.assign(draft.mesh.vertices.size(), -1);
  progress.report(0.1, "opening the ends");
  detail::open_ends(draft, tree, detail::line_ends(tree), warnings);
  detail::set_edge_lengths(draft, target, tree, options,
                           kLeastEdge * shortest_spacing(padded.geometry), warnings);
  progress.report(0.2, "remeshing");
  if (options.triangle_count > 0) detail::aim_at_count(draft, options.triangle_count);
  const double tolerance = kTolerance * shortest_spacing(padded.geometry);
  shape_surface(draft, target, tolerance, options, progress, warnings);
  progress.report(0.9, "caps and checks");
  LumenMesh result = finish(std::move(draft), target, options, std::move(warnings));
  progress.report(1.0);
  return result;
}

LumenMesh mesh_lumen(const TriangleMesh& surface, const CenterlineTree& tree,
                     const LumenMeshOptions& options, const Progress& progress,
                     const std::vector<WidenedStretch>& widened) {
  options.validate();
  check_tree(tree);
  if (options.keep) return keep_surface(surface, tree, options);
  progress.report(0.0, "repairing the surface");
  std::vector<std::string> warnings;
  const std::vector<LineEnd> ends = detail::line_ends(tree);
  detail::OpenedSurface opened = detail::open_surface(surface, tree, ends, warnings);
  const detail::MeshTarget target(opened.repaired);
  const detail::Widening widening = widening_for(options, tree, widened);
  SurfaceDraft draft = std::move(opened.draft);
  draft.widening = &widening;
  // A given surface may have long triangles, which do not show where the lumen is narrow: the
  // lengths are set again once there are vertices everywhere.
  std::vector<std::string> first_warnings;
  detail::set_edge_lengths(draft, target, tree, options, 0.0, first_warnings);
  progress.report(0.2, "remeshing");
  detail::remesh(draft, target, 2);
  detail::set_edge_lengths(draft, target, tree, options, 0.0, warnings);
  if (options.triangle_count > 0) detail::aim_at_count(draft, options.triangle_count);
  constexpr double kNoTolerance = std::numeric_limits<double>::infinity();
  shape_surface(draft, target, kNoTolerance, options, progress, warnings);
  progress.report(0.9, "caps and checks");
  LumenMesh result = finish(std::move(draft), target, options, std::move(warnings));
  progress.report(1.0);
  return result;
}

int count_self_intersections(const TriangleMesh& mesh) {
  return int(air_mesh::self_intersections(mesh).size());
}

int count_intersections(const TriangleMesh& mesh_a, const TriangleMesh& mesh_b) {
  return int(air_mesh::intersections(mesh_a, mesh_b).size());
}

}  // namespace angio::meshing
