#include "centerline/centerline.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "centerline/detail/contacts.hpp"
#include "centerline/detail/lines.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/side_by_side.hpp"
#include "centerline/detail/skeleton.hpp"
#include "centerline/detail/smooth_surface.hpp"
#include "centerline/detail/surface_wall.hpp"
#include "centerline/detail/tracts.hpp"
#include "centerline/detail/wall.hpp"
#include "centerline/detail/wall_points.hpp"
#include "core/error.hpp"

namespace angio::centerline {

void CenterlineOptions::validate() const {
  if (!(step_mm >= 0.0 && step_mm <= 5.0))
    throw OptionError("centerline.step_mm is " + std::to_string(step_mm) +
                      ". Give 0 (a quarter of the radius) or up to 5 mm");
  if (!(min_branch_length_mm >= 0.0 && std::isfinite(min_branch_length_mm)))
    throw OptionError("centerline.min_branch_length_mm is " + std::to_string(min_branch_length_mm) +
                      ". Give 0 (by the radius) or more");
}

namespace {

/// What level sets and surfaces have in common: the voxels tell where the lines run, the points of
/// the wall where exactly their middle is.
/// @param vertices  of the surface that was filled; none: the level set's own wall is measured
CenterlineResult extract(const Volume<float>& level_set, std::optional<std::vector<Vec3>> vertices,
                         const CenterlineOptions& options, const Progress& progress) {
  LumenVoxelsResult lumen = find_lumen_voxels(level_set);
  const LevelSetWall wall(level_set);
  const WallPoints points =
      vertices ? WallPoints(std::move(*vertices)) : WallPoints(level_set, lumen.voxels);
  progress.report(0.2, "finding the ends");
  Skeleton skeleton = find_skeleton(lumen.voxels, options);
  progress.report(0.4, "centring lines");
  CenterlineResult result;
  result.tree = trace_lines(lumen.voxels, skeleton, wall, points, options.step_mm, progress);
  assign_tracts(result.tree);
  result.warnings = std::move(skeleton.warnings);
  for (std::string& contact : find_contacts(result.tree))
    result.warnings.push_back(std::move(contact));
  for (std::string& pair : find_vessels_side_by_side(result.tree, level_set))
    result.warnings.push_back(std::move(pair));
  result.left_out = 1.0 - lumen.largest_fraction;
  if (lumen.piece_count > 1)
    result.warnings.push_back("the lumen has " + std::to_string(lumen.piece_count) +
                              " separate pieces; lines were found in the largest (" +
                              std::to_string(int(std::lround(100.0 * lumen.largest_fraction))) +
                              " % of the voxels)");
  progress.report(1.0);
  return result;
}

/// Voxels for a surface: a fifth of the thinnest vessels' diameter, but no more than memory and
/// time allow.
double choose_spacing(const SurfaceWall& wall) {
  constexpr double kMostVoxels = 3e7, kMostInside = 1e6;
  const std::vector<double> diameters = wall.diameters(5000);
  if (diameters.empty())
    throw InputError(
        "the surface has no inside (no ray from its wall meets the wall again). Check its normals");
  Vec3 low = wall.mesh().vertices.front(), high = low;
  for (const Vec3& p : wall.mesh().vertices)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  const Vec3 size = high - low;
  const double thin = diameters[diameters.size() / 50];  // 2 %: caps' edges look thinner still
  return std::max({thin / 5.0, std::cbrt(size.x * size.y * size.z / kMostVoxels),
                   std::cbrt(enclosed_volume(wall.mesh()) / kMostInside)});
}

}  // namespace

CenterlineResult extract_centerline(const Volume<float>& level_set,
                                    const CenterlineOptions& options, const Progress& progress) {
  options.validate();
  progress.report(0.0, "finding the lumen");
  return extract(level_set, std::nullopt, options, progress);
}

CenterlineResult extract_centerline(const TriangleMesh& surface, const CenterlineOptions& options,
                                    const Progress& progress) {
  options.validate();
  progress.report(0.0, "filling the surface");
  ClosedSurface closed = close_surface(surface);
  std::vector<Vec3> vertices = closed.mesh.vertices;
  vertices.resize(std::size_t(closed.wall_vertex_count));
  constexpr double kRough = 0.1;
  if (roughness(closed.mesh) > kRough) smooth_surface(closed.mesh, 15);
  const Volume<float> level_set = voxelize(closed.mesh, choose_spacing(SurfaceWall(closed.mesh)));
  return extract(level_set, std::move(vertices), options, progress);
}

}  // namespace angio::centerline
