#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <queue>

#include "core/error.hpp"
#include "meshing/detail/isosurface.hpp"
#include "meshing/detail/nearest_line.hpp"
#include "meshing/detail/open_ends.hpp"
#include "meshing/detail/remesh.hpp"
#include "meshing/detail/surface_query.hpp"
#include "meshing/detail/surface_target.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing {
namespace {

using detail::LineEnd;
using detail::Plane;
using detail::SurfaceDraft;
using detail::SurfaceTarget;

void check_tree(const CenterlineTree& tree) {
  if (tree.paths.empty())
    throw InputError(
        "the centreline has no line (nothing says which lumen to mesh). Run the stage "
        "centerline again");
}

/// The connected piece of each vertex, numbered from 0 by its first vertex.
std::vector<int> vertex_components(const TriangleMesh& mesh) {
  std::vector<int> parent(mesh.vertices.size());
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = int(v);
  const auto root = [&](int v) {
    while (parent[std::size_t(v)] != v) {
      parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
      v = parent[std::size_t(v)];
    }
    return v;
  };
  for (const Triangle& t : mesh.triangles) {
    const int a = root(t[0]);
    for (const int v : {root(t[1]), root(t[2])})
      parent[std::size_t(std::max(a, v))] = std::min(a, v);
  }
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = root(int(v));
  return parent;
}

/// Keeps the triangles of which `keep` is true, and the vertices they use.
TriangleMesh part_of(const TriangleMesh& mesh, const auto& keep) {
  TriangleMesh part;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (const Triangle& t : mesh.triangles) {
    if (!keep(t)) continue;
    Triangle renamed{};
    for (std::size_t c = 0; c < 3; ++c) {
      int& at = index[std::size_t(t[c])];
      if (at < 0) {
        at = int(part.vertices.size());
        part.vertices.push_back(mesh.vertices[std::size_t(t[c])]);
      }
      renamed[c] = at;
    }
    part.triangles.push_back(renamed);
  }
  return part;
}

/// The piece that the centreline runs through: the one nearest to most of its points.
TriangleMesh component_of_lines(const TriangleMesh& mesh, const CenterlineTree& tree) {
  const std::vector<int> component = vertex_components(mesh);
  std::map<int, int> votes;
  constexpr std::size_t kSamples = 16;  // a path
  for (const CenterlinePath& path : tree.paths) {
    const std::size_t stride = std::max<std::size_t>(1, path.points.size() / kSamples);
    for (std::size_t i = 0; i < path.points.size(); i += stride) {
      double best = std::numeric_limits<double>::infinity();
      int owner = 0;
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const double squared = norm_squared(mesh.vertices[v] - path.points[i]);
        if (squared >= best) continue;
        best = squared;
        owner = component[v];
      }
      ++votes[owner];
    }
  }
  const auto most = std::max_element(
      votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return part_of(mesh,
                 [&](const Triangle& t) { return component[std::size_t(t[0])] == most->first; });
}

/// An opening of a given surface.
struct Opening {
  std::vector<int> loop;
  Vec3 centre;
  double radius = 0.0;      ///< mean distance from the centre [mm]
  Plane plane;              ///< its normal leaves the lumen
  double unevenness = 0.0;  ///< largest distance from the plane [mm]
};
Opening describe_opening(const TriangleMesh& mesh, std::vector<int> loop) {
  Opening opening;
  const double share = 1.0 / double(loop.size());
  const auto at = [&](std::size_t i) { return mesh.vertices[std::size_t(loop[i % loop.size()])]; };
  for (std::size_t i = 0; i < loop.size(); ++i) opening.centre += share * at(i);
  Vec3 area;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    area += cross(at(i) - opening.centre, at(i + 1) - opening.centre);
    opening.radius += share * distance(at(i), opening.centre);
  }
  opening.plane = {opening.centre, normalized(area)};
  for (std::size_t i = 0; i < loop.size(); ++i)
    opening.unevenness =
        std::max(opening.unevenness, std::abs(opening.plane.signed_distance(at(i))));
  opening.loop = std::move(loop);
  return opening;
}

/// Fills every opening; where one has no filling, the surface cannot be used.
void fill_opening(TriangleMesh& mesh, const std::vector<int>& loop) {
  std::vector<Vec3> points;
  for (const int v : loop) points.push_back(mesh.vertices[std::size_t(v)]);
  const std::vector<Triangle> patch = detail::triangulate_loop(points);
  if (patch.empty())
    throw InputError("a hole of the surface cannot be filled (" + std::to_string(loop.size()) +
                     " vertices on its border). Repair the surface first");
  for (const Triangle& t : patch)
    mesh.triangles.push_back(
        {loop[std::size_t(t[0])], loop[std::size_t(t[1])], loop[std::size_t(t[2])]});
}

void turn_outward(TriangleMesh& mesh) {
  TriangleMesh closed = mesh;
  for (const auto& loop : boundary_loops(mesh)) fill_opening(closed, loop);
  if (enclosed_volume(closed) > 0.0) return;
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

/// A given surface made manifold and outward; flat openings at line ends stay, others are filled.
SurfaceDraft repaired_draft(const TriangleMesh& surface, const CenterlineTree& tree,
                            const std::vector<LineEnd>& ends) {
  SurfaceDraft draft;
  draft.mesh = detail::repair_surface(surface);
  if (draft.mesh.triangles.empty())
    throw InputError("the surface has no triangles (nothing is left of it after repair)");
  draft.mesh = component_of_lines(draft.mesh, tree);
  turn_outward(draft.mesh);
  draft.rim.assign(draft.mesh.vertices.size(), -1);
  draft.rim_planes.resize(ends.size());
  std::vector<char> taken(ends.size(), 0);
  for (const auto& loop : boundary_loops(draft.mesh)) {
    const Opening opening = describe_opening(draft.mesh, loop);
    int nearest = -1;
    for (std::size_t e = 0; e < ends.size(); ++e) {
      const double reach = 1.5 * std::max(ends[e].radius, opening.radius);
      const double d = distance(ends[e].tip, opening.centre);
      if (!taken[e] && d < reach &&
          (nearest < 0 || d < distance(ends[std::size_t(nearest)].tip, opening.centre)))
        nearest = int(e);
    }
    constexpr double kFlat = 0.1;  // unevenness / radius of a rim that is straightened
    const bool keep = nearest >= 0 && opening.unevenness < kFlat * opening.radius &&
                      opening.radius > 0.5 * ends[std::size_t(nearest)].radius;
    if (!keep) {
      fill_opening(draft.mesh, loop);
      continue;
    }
    taken[std::size_t(nearest)] = 1;
    draft.rim_planes[std::size_t(nearest)] = opening.plane;
    for (const int v : loop) {
      Vec3& x = draft.mesh.vertices[std::size_t(v)];
      x -= opening.plane.signed_distance(x) * opening.plane.normal;
      draft.rim[std::size_t(v)] = nearest;
    }
  }
  return draft;
}

/// Opens the lumen at every line end that is not open yet.
void open_ends(SurfaceDraft& draft, const CenterlineTree& tree, const std::vector<LineEnd>& ends,
               std::vector<std::string>& warnings) {
  draft.rim_planes.resize(ends.size());
  for (std::size_t e = 0; e < ends.size(); ++e) {
    if (std::find(draft.rim.begin(), draft.rim.end(), int(e)) != draft.rim.end()) continue;
    std::vector<Vec3> keep;
    for (std::size_t other = 0; other < ends.size(); ++other)
      if (other != e) keep.push_back(ends[other].tip);
    const double inset = detail::full_width_inset(tree, ends[e]);
    bool done = false;
    for (const double factor : {1.0, 1.4, 0.7, 2.0, 0.4, 3.0, 4.0, 0.1}) {
      const Plane plane = detail::plane_near_end(tree, ends[e], factor * inset);
      draft.rim_planes[e] = plane;
      done = detail::open_end(draft.mesh, draft.rim, plane, ends[e].radius, int(e), keep);
      if (done) break;
    }
    if (!done)
      warnings.push_back((e == 0 ? std::string("the inlet") : "outlet " + std::to_string(e)) +
                         " could not be opened (no plane across the line's end has a closed "
                         "section there); it stays closed");
  }
}

/// Lets wanted lengths grow by a fifth of the way only, so that neighbouring triangles are alike.
void limit_growth(const TriangleMesh& mesh, std::vector<double>& lengths) {
  constexpr double kGrowth = 0.2;
  const auto neighbors = vertex_neighbors(mesh);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::size_t v = 0; v < lengths.size(); ++v) queue.push({lengths[v], int(v)});
  while (!queue.empty()) {
    const auto [length, v] = queue.top();
    queue.pop();
    if (length > lengths[std::size_t(v)]) continue;
    for (const int u : neighbors[std::size_t(v)]) {
      const double limit =
          length + kGrowth * distance(mesh.vertices[std::size_t(v)], mesh.vertices[std::size_t(u)]);
      if (limit >= lengths[std::size_t(u)]) continue;
      lengths[std::size_t(u)] = limit;
      queue.push({limit, u});
    }
  }
}

/// Wanted edge lengths: 2 pi r / edges_per_circumference with r from the nearest line, lengthened
/// evenly where the triangle budget asks for it.
void set_edge_lengths(SurfaceDraft& draft, const CenterlineTree& tree,
                      const LumenMeshOptions& options, double least_length,
                      std::vector<std::string>& warnings) {
  const TriangleMesh& mesh = draft.mesh;
  draft.edge_length.assign(mesh.vertices.size(), options.edge_length_mm);
  if (options.edge_length_mm == 0.0) {
    const detail::NearestLine lines(tree);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      draft.edge_length[v] =
          std::max(least_length, 2.0 * std::numbers::pi * lines.find(mesh.vertices[v]).radius /
                                     options.edges_per_circumference);
    limit_growth(mesh, draft.edge_length);
  }
  const std::vector<double> areas = vertex_areas(mesh);
  double count = 0.0;  // equilateral triangles have sqrt(3)/4 L^2; remeshing leaves edges near L
  for (std::size_t v = 0; v < areas.size(); ++v)
    count += areas[v] / (0.25 * std::numbers::sqrt3 * draft.edge_length[v] * draft.edge_length[v]);
  const double share = 1.15 * count / options.triangle_budget;
  if (share <= 1.0) return;
  for (double& length : draft.edge_length) length *= std::sqrt(share);
  warnings.push_back("the lumen's edges were lengthened by " +
                     std::to_string(std::lround(100.0 * (std::sqrt(share) - 1.0))) +
                     " % to keep the triangle budget");
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
  limit_growth(draft.mesh, draft.edge_length);
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
  draft.mesh = component_of_lines(detail::extract_isosurface(padded), tree);
  draft.rim.assign(draft.mesh.vertices.size(), -1);
  progress.report(0.1, "opening the ends");
  open_ends(draft, tree, detail::line_ends(tree), warnings);
  set_edge_lengths(draft, tree, options, least_edge_length(padded.geometry), warnings);
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
  SurfaceDraft draft = repaired_draft(surface, tree, ends);
  const TriangleMesh original = draft.mesh;
  const detail::MeshTarget target(original);
  progress.report(0.1, "opening the ends");
  open_ends(draft, tree, ends, warnings);
  // A given surface may have long triangles, which do not show where the lumen is narrow: the
  // lengths are set again once there are vertices everywhere.
  std::vector<std::string> first_warnings;
  set_edge_lengths(draft, tree, options, 0.0, first_warnings);
  progress.report(0.2, "remeshing");
  detail::remesh(draft, target, 2);
  set_edge_lengths(draft, tree, options, 0.0, warnings);
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
