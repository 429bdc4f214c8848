#include "centerline/centerline.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "centerline/detail/contacts.hpp"
#include "centerline/detail/flat_caps.hpp"
#include "centerline/detail/lines.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/open_throats.hpp"
#include "centerline/detail/places.hpp"
#include "centerline/detail/side_by_side.hpp"
#include "centerline/detail/skeleton.hpp"
#include "centerline/detail/smooth_surface.hpp"
#include "centerline/detail/surface_wall.hpp"
#include "centerline/detail/tracts.hpp"
#include "centerline/detail/wall.hpp"
#include "centerline/detail/wall_distance.hpp"
#include "centerline/detail/wall_points.hpp"
#include "core/error.hpp"
#include "core/require.hpp"
#include "core/units.hpp"

namespace angio::centerline {

void CenterlineOptions::validate() const {
  require_within("centerline.step_mm", step_mm, 0.0, 5.0, ". 0 means a quarter of the radius");
  if (!(min_branch_length_mm >= 0.0 && std::isfinite(min_branch_length_mm)))
    throw OptionError("centerline.min_branch_length_mm is " + std::to_string(min_branch_length_mm) +
                      ". Give 0 (by the radius) or more");
  ANGIO_EXPECT(least_throat_mm >= 0.0);
}

namespace {

/// The distance of points where the user gives none: a quarter of the radius.
std::function<double(double)> last_step(const CenterlineOptions& options, const Wall& wall) {
  constexpr double kStep = 0.25;  // of the radius, and of what the data can show
  return [given = options.step_mm, least = kStep * wall.resolution()](double radius) {
    return given > 0.0 ? given : std::max(kStep * radius, least);
  };
}

/// A surface as it came, closed.
struct GivenSurface {
  SurfaceWall triangles;
  int wall_vertex_count;
  bool has_caps;  ///< the rims are those of flat caps that were removed
  std::vector<OpenRim> flat_ends;
  [[nodiscard]] std::vector<Vec3> wall_vertices() const {
    const auto begin = triangles.mesh().vertices.begin();
    return {begin, begin + wall_vertex_count};
  }
  [[nodiscard]] Openings openings() const {
    Openings openings{rims(), has_caps, flat_ends};
    std::erase_if(openings.flat_ends, [&](const OpenRim& end) {  // the fan over a rim is flat, too
      return std::any_of(openings.rims.begin(), openings.rims.end(), [&](const OpenRim& rim) {
        return distance(rim.middle, end.middle) < std::max(rim.radius, end.radius);
      });
    });
    return openings;
  }

 private:
  /// What the fans have closed.
  [[nodiscard]] std::vector<OpenRim> rims() const {
    const TriangleMesh& mesh = triangles.mesh();
    std::vector<OpenRim> rims;
    for (auto v = std::size_t(wall_vertex_count); v < mesh.vertices.size(); ++v)
      rims.push_back({mesh.vertices[v], 0.0});
    for (const auto& t : mesh.triangles)
      for (const int v : t)
        if (v >= wall_vertex_count)
          rims[std::size_t(v - wall_vertex_count)].radius +=
              0.5 * norm(area_vector_doubled(mesh, t));
    for (OpenRim& rim : rims) rim.radius = std::sqrt(rim.radius / units::kPi);
    return rims;
  }
};

/// What a lumen is measured in.
struct Lumen {
  const Volume<float>& level_set;
  const GivenSurface* surface;  ///< that was filled; null: the level set's own wall is measured
};

/// Points of lines that lie over a voxel outside of the lumen, in words; empty: none, or too few to
/// tell of. Lines reach up to a radius beyond open ends.
std::string points_outside(const CenterlineTree& tree, const Volume<float>& level_set) {
  constexpr double kShare = 0.01;
  const double voxel = level_set.geometry.longest_spacing();
  std::size_t all = 0;
  std::vector<Vec3> outside;
  for (const CenterlinePath& path : tree.paths)
    for (std::size_t n = 0; n < path.points.size(); ++n) {
      const double to_end = std::min(path.abscissa[n], path.abscissa.back() - path.abscissa[n]);
      if (to_end < path.tube_radius[n]) continue;
      ++all;
      if (interpolate(level_set, path.points[n]) > voxel) outside.push_back(path.points[n]);
    }
  if (double(outside.size()) <= kShare * double(all)) return {};
  const std::size_t count = outside.size();
  outside = {outside[count / 2]};
  return std::to_string(count) + " of " + std::to_string(all) +
         " points of the lines lie outside the lumen, as " + at_places(outside) +
         ": what is measured there is no lumen (a wall of two sides, a shape that is no vessel, or "
         "several that touch). Look at the lines before you trust a number";
}

/// What level sets and surfaces have in common: the voxels tell where the lines run, the points of
/// the wall where exactly their middle is.
CenterlineResult extract_tree(const Lumen& lumen, LumenVoxels& voxels, const Openings& openings,
                              const CenterlineOptions& options, const Progress& progress) {
  const LevelSetWall wall(lumen.level_set);
  const WallPoints points = lumen.surface ? WallPoints(lumen.surface->wall_vertices())
                                          : WallPoints(lumen.level_set, voxels, options.voxel_mm);
  const WallDistance distance_to_wall =
      lumen.surface
          ? WallDistance(points, lumen.surface->triangles, lumen.surface->wall_vertex_count)
          : WallDistance(points);
  progress.report(0.0, "finding the ends");
  Skeleton skeleton = find_skeleton(voxels, options, openings, part(progress, 0.0, 0.25));
  progress.report(0.25, "centring lines");
  CenterlineResult result;
  const Surroundings around{voxels, wall, points, distance_to_wall, last_step(options, wall)};
  TracedLines lines = trace_lines(skeleton, around, part(progress, 0.25, 1.0));
  result.tree = std::move(lines.tree);
  result.warnings = std::move(skeleton.warnings);
  for (std::string& note : assign_tracts(result.tree, lines.is_tube, lines.is_cut))
    result.warnings.push_back(std::move(note));
  if (const std::vector<Vec3> contacts = find_contacts(result.tree); !contacts.empty())
    result.warnings.push_back(
        "two vessels seem to touch " + at_places(contacts) +
        " (two branches lie on one line that runs past the vessel they leave); the lines go "
        "through the contact. Check the place, and name the outlets that are wanted");
  if (options.inlet_lps_mm) {
    constexpr double kFar = 5.0;  // [mm]
    const Vec3& asked = *options.inlet_lps_mm;
    const double away = distance(voxels.position(voxels.nearest(asked)), asked);
    if (away > kFar)
      result.warnings.push_back("the inlet that was named lies " + std::to_string(int(away)) +
                                " mm from the lumen; the end nearest to it was taken. Points are "
                                "in LPS [mm]: check the order and the signs");
  }
  if (std::string note = points_outside(result.tree, lumen.level_set); !note.empty())
    result.warnings.push_back(std::move(note));
  for (std::string& pair : find_vessels_side_by_side(result.tree, lumen.level_set))
    result.warnings.push_back(
        std::move(pair) +
        (lumen.surface ? "; a surface of one of them takes it without the other"
                       : "; a higher segmentation.intensity_min or finer voxels may part them"));
  return result;
}

/// The piece that a place lies in, or nearest to.
std::size_t piece_at(const std::vector<LumenVoxels>& pieces, const Vec3& place) {
  if (pieces.size() == 1) return 0;
  std::vector<double> away;
  for (const LumenVoxels& piece : pieces)
    away.push_back(distance(piece.position(piece.nearest(place)), place));
  return std::size_t(std::min_element(away.begin(), away.end()) - away.begin());
}

/// What a piece's own tree is made with.
struct TreeOrder {
  CenterlineOptions options;
  Openings openings;
  bool is_wanted = true;  ///< false: outlets are named, and all lie elsewhere
};

/// Named ends and the surface's openings, each given to the piece that it lies in.
std::vector<TreeOrder> orders_for(const std::vector<LumenVoxels>& pieces,
                                  const CenterlineOptions& options, const Openings& openings) {
  TreeOrder order{options, openings};
  order.options.inlet_lps_mm.reset();
  order.options.outlets_lps_mm.clear();
  order.openings.rims.clear();
  order.openings.flat_ends.clear();
  order.is_wanted = options.outlets_lps_mm.empty();
  std::vector<TreeOrder> orders(pieces.size(), order);
  if (options.inlet_lps_mm)
    orders[piece_at(pieces, *options.inlet_lps_mm)].options.inlet_lps_mm = options.inlet_lps_mm;
  for (const Vec3& outlet : options.outlets_lps_mm) {
    TreeOrder& own = orders[piece_at(pieces, outlet)];
    own.options.outlets_lps_mm.push_back(outlet);
    own.is_wanted = true;
  }
  for (const OpenRim& rim : openings.rims)
    orders[piece_at(pieces, rim.middle)].openings.rims.push_back(rim);
  for (const OpenRim& end : openings.flat_ends)
    orders[piece_at(pieces, end.middle)].openings.flat_ends.push_back(end);
  return orders;
}

/// Adds a tree's lines behind those that are there, with ids of their own.
void add_tree(CenterlineTree tree, CenterlineTree& lines) {
  int first_group = 0;
  for (const CenterlinePath& path : lines.paths)
    for (const CenterlineTract& tract : path.tracts)
      first_group = std::max(first_group, tract.group_id + 1);
  for (CenterlinePath& path : tree.paths) {
    path.id = int(lines.paths.size());
    for (CenterlineTract& tract : path.tracts) tract.group_id += first_group;
    lines.paths.push_back(std::move(path));
  }
}

double longest_mm(const CenterlineTree& tree) {
  double longest = 0.0;
  for (const CenterlinePath& path : tree.paths) longest = std::max(longest, path.abscissa.back());
  return longest;
}

double widest_mm(const CenterlineTree& tree) {
  double widest = 0.0;
  for (const CenterlinePath& path : tree.paths)
    for (const double radius : path.inscribed_radius) widest = std::max(widest, 2.0 * radius);
  return widest;
}

/// Whether a piece beside the largest is worth lines: a stump, of which hardly more is seen than
/// its cut ends, is not.
bool is_long(const CenterlineTree& tree) {
  constexpr double kLong = 8.0;  // radii
  const CenterlinePath& path = tree.paths.front();
  const auto& radius = path.inscribed_radius;
  return path.abscissa.back() > kLong * *std::max_element(radius.begin(), radius.end());
}

/// The trees of all pieces; small ones and those that are no vessels are left out.
CenterlineResult extract(const Lumen& lumen, const CenterlineOptions& options,
                         const Progress& progress) {
  LumenPieces found = find_lumen_pieces(lumen.level_set);
  const std::size_t count = found.pieces.size();
  const std::vector<TreeOrder> orders =
      orders_for(found.pieces, options, lumen.surface ? lumen.surface->openings() : Openings{});
  CenterlineResult result;
  result.left_out = 1.0;
  result.beside_largest = 1.0 - found.voxel_share.front();
  std::string refusal;
  for (std::size_t n = 0; n < count; ++n) {
    if (!orders[n].is_wanted) continue;
    const double begin = 0.2 + 0.8 * double(n) / double(count);
    try {
      CenterlineResult tree =
          extract_tree(lumen, found.pieces[n], orders[n].openings, orders[n].options,
                       part(progress, begin, begin + 0.8 / double(count)));
      if (result.tree_count > 0 && !is_long(tree.tree)) continue;
      add_tree(std::move(tree.tree), result.tree);
      result.left_out -= found.voxel_share[n];
      ++result.tree_count;
      for (std::string& warning : tree.warnings) result.warnings.push_back(std::move(warning));
    } catch (const InputError& error) {
      if (count == 1) throw;
      if (refusal.empty()) refusal = error.what();
    }
  }
  if (result.tree_count == 0) throw InputError(refusal);
  if (result.tree_count == 1 && longest_mm(result.tree) < widest_mm(result.tree))
    result.warnings.push_back(
        "the lines are shorter than the lumen is wide: it is no vessel (a block, an organ, a "
        "chamber, or what lies around vessels). Give the lumen alone");
  result.left_out = std::max(0.0, result.left_out);
  if (found.piece_count > 1)
    result.warnings.push_back(
        "the lumen has " + std::to_string(found.piece_count) +
        " separate pieces; lines were found in " +
        (result.tree_count == 1 ? "one"
                                : std::to_string(result.tree_count) +
                                      " of them, each a tree with an inlet of its own") +
        " (" + std::to_string(int(std::lround(100.0 * (1.0 - result.left_out)))) +
        " % of the lumen)");
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

/// The lumen of a surface in voxels.
Volume<float> fill(const SurfaceWall& wall, double least_throat_mm) {
  Volume<float> level_set = voxelize(wall.mesh(), choose_spacing(wall));
  open_throats(level_set, wall, least_throat_mm);
  return level_set;
}

}  // namespace

CenterlineResult extract_centerline(const Volume<float>& level_set,
                                    const CenterlineOptions& options, const Progress& progress) {
  options.validate();
  progress.report(0.0, "finding the lumen");
  return extract({level_set, nullptr}, options, progress);
}

CenterlineResult extract_centerline(const TriangleMesh& surface, const CenterlineOptions& options,
                                    const Progress& progress) {
  options.validate();
  progress.report(0.0, "filling the surface");
  ClosedSurface closed = close_surface(surface);
  constexpr double kRough = 0.1, kStairs = 0.2;  // the stairs of a voxel mask have flat tops, too
  const double rough = roughness(closed.mesh);
  const bool is_rough = rough > kRough;
  const bool was_closed = closed.wall_vertex_count == int(closed.mesh.vertices.size());
  if (rough < kStairs && was_closed)
    closed = close_surface(remove_flat_caps(closed.mesh));  // flat caps are ends, as rims are
  const GivenSurface given{SurfaceWall(closed.mesh), closed.wall_vertex_count, was_closed,
                           is_rough ? std::vector<OpenRim>{} : find_flat_ends(closed.mesh)};
  if (is_rough) smooth_surface(closed.mesh, 15);
  const Volume<float> level_set = fill(SurfaceWall(closed.mesh), options.least_throat_mm);
  return extract({level_set, &given}, options, progress);
}

}  // namespace angio::centerline
