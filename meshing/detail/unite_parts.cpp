#include "meshing/detail/unite_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "air_mesh/build/surface_crossings.hpp"
#include "core/parallel.hpp"
#include "core/volume.hpp"
#include "meshing/detail/crossings.hpp"
#include "meshing/detail/isosurface.hpp"
#include "meshing/detail/mend_holes.hpp"
#include "meshing/detail/pieces.hpp"
#include "meshing/detail/soup.hpp"
#include "meshing/detail/surface_query.hpp"
#include "meshing/detail/winding.hpp"
#include "meshing/surface_size.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kSameVolume = 0.02;
constexpr double kLinesAcross = 10.0;  // the thinnest part

/// The median diameter of the thinnest part.
double thinnest(const std::vector<TriangleMesh>& parts) {
  double least = std::numeric_limits<double>::infinity();
  for (const TriangleMesh& part : parts) {
    const double median = median_diameter(part);
    if (median > 0.0) least = std::min(least, median);
  }
  if (std::isfinite(least)) return least;
  return std::cbrt(std::abs(enclosed_volume(joined(parts))));
}

bool is_whole(const TriangleMesh& mesh, double volume) {
  return !mesh.triangles.empty() && surface_topology(mesh).is_closed() &&
         std::abs(enclosed_volume(mesh) - volume) <= kSameVolume * volume &&
         air_mesh::self_intersections(mesh).empty();
}

/// Part after part, each one that meets what is united so far. @return empty if one cannot be
TriangleMesh unite_exactly(std::vector<TriangleMesh> parts) {
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) {
    return std::abs(enclosed_volume(a)) > std::abs(enclosed_volume(b));
  });
  for (TriangleMesh& part : parts)  // an exact union asks for parts that do not cross themselves
    if (!air_mesh::self_intersections(part).empty()) close_crossings(part);
  TriangleMesh whole = std::move(parts.front());
  parts.erase(parts.begin());
  while (!parts.empty()) {
    const auto next = std::find_if(parts.begin(), parts.end(), [&](const TriangleMesh& part) {
      return !air_mesh::intersections(whole, part).empty();
    });
    if (next == parts.end()) return {};
    if (!unite_solids(whole, *next)) return {};
    parts.erase(next);
  }
  // Points where triangles cross are rounded, after which slivers may cross.
  if (!air_mesh::self_intersections(whole).empty()) close_crossings(whole);
  return whole;
}

/// The triangles that have the outside on one side, at a corner or in the middle.
TriangleMesh exposed_part(const TriangleMesh& closed, const Winding& winding, double step) {
  std::vector<char> keep(closed.triangles.size(), 0);
  parallel_for_uneven(std::ptrdiff_t(keep.size()), [&](std::ptrdiff_t index) {
    const Triangle& t = closed.triangles[std::size_t(index)];
    const Vec3 out = 0.01 * step * normalized(area_vector_doubled(closed, t));
    Vec3 middle;
    for (const int v : t) middle += closed.vertices[std::size_t(v)] / 3.0;
    bool exposed = winding.at(middle + out) <= 0;
    for (const int v : t)
      exposed = exposed ||
                winding.at(middle + 0.9 * (closed.vertices[std::size_t(v)] - middle) + out) <= 0;
    keep[std::size_t(index)] = exposed ? 1 : 0;
  });
  return part_of(closed, keep);
}

/// -1 where the winding number is above 0, 1 elsewhere.
Volume<float> union_signs(const Winding& winding, const VolumeGeometry& grid) {
  Volume<float> signs(grid, 1.0F);
  parallel_for_uneven(grid.size[2], [&](std::ptrdiff_t layer) {
    const int k = int(layer);
    for (int j = 0; j < grid.size[1]; ++j) {
      const Vec3 row = grid.lps_from_index({0.0, double(j), double(k)});
      int turns = 0;
      int i = 0;
      for (const auto& [x, change] : winding.crossings(row.y, row.z)) {
        const int end = std::clamp(int(std::ceil((x - row.x) / grid.spacing.x)), 0, grid.size[0]);
        for (; i < end; ++i)
          if (turns > 0) signs.at(i, j, k) = -1.0F;
        turns += change;
      }
    }
  });
  return signs;
}

/// Signed distance [mm] from the union's wall at the nodes whose neighbours lie on its other side,
/// two steps elsewhere: all that a contour asks for.
Volume<float> union_level_set(const TriangleMesh& closed, const VolumeGeometry& grid) {
  const Winding winding(closed);
  const double step = grid.spacing.x;
  const TriangleMesh exposed = exposed_part(closed, winding, step);
  const ClosestPoint wall(exposed);
  const Volume<float> signs = union_signs(winding, grid);
  Volume<float> level_set = signs;
  parallel_for_uneven(grid.size[2], [&](std::ptrdiff_t layer) {
    const int k = int(layer);
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const float own = signs.at(i, j, k);
        bool at_wall = false;
        for (int n = 0; n < 27 && !at_wall; ++n) {
          const int a = i + n % 3 - 1, b = j + n / 3 % 3 - 1, c = k + n / 9 - 1;
          at_wall = grid.contains(a, b, c) && signs.at(a, b, c) != own;
        }
        const double distance =
            at_wall
                ? std::min(
                      wall.find(grid.lps_from_index({double(i), double(j), double(k)})).distance,
                      2.0 * step)
                : 2.0 * step;
        level_set.at(i, j, k) = own * std::max(float(distance), 1e-6F * float(step));
      }
  });
  return level_set;
}

/// @return empty if the grid would be too large for the thinnest part
TriangleMesh contour_union(const TriangleMesh& closed, double thin) {
  constexpr double kAcross = 8.0;  // steps of the grid over the thinnest part
  constexpr double kLeastAcross = 4.0;
  constexpr double kMostNodes = 3e7;
  constexpr double kCrumb = 1e-3;       // of the volume
  constexpr double kOff = 1.234567e-4;  // steps; the lines miss the vertices of constructions
  Vec3 low = closed.vertices.front(), high = low;
  for (const Vec3& p : closed.vertices)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  const Vec3 sides = high - low;
  const double step = std::max(thin / kAcross, std::cbrt(sides.x * sides.y * sides.z / kMostNodes));
  if (step > thin / kLeastAcross) return {};
  VolumeGeometry grid;
  grid.spacing = {step, step, step};
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[std::size_t(axis)] = int(sides[axis] / step) + 8;
    grid.origin[axis] = low[axis] - (3.0 + kOff) * step;
  }
  const TriangleMesh contour = extract_isosurface(union_level_set(closed, grid));
  const double least = kCrumb * enclosed_volume(contour);
  std::vector<TriangleMesh> solids = connected_pieces(contour);
  std::erase_if(solids, [&](const TriangleMesh& piece) {  // crumbs, and walls of hollows inside
    return enclosed_volume(piece) < least;
  });
  return solids.empty() ? TriangleMesh() : joined(solids);
}

}  // namespace

Union unite_parts(const std::vector<TriangleMesh>& parts) {
  constexpr double kTouch = 1e-3;  // of the union; less is no overlap
  const TriangleMesh closed = joined(parts);
  const double thin = thinnest(parts);
  const double volume = wound_volume(closed, thin / kLinesAcross, 1);
  Union result;
  result.mesh = parts.size() > 1 ? unite_exactly(parts) : TriangleMesh();
  if (is_whole(result.mesh, volume)) return result;
  result.mesh = {};
  if (wound_volume(closed, thin / kLinesAcross, 2) < kTouch * volume && parts.size() > 1) {
    result.only_touch = true;
    return result;
  }
  result.mesh = contour_union(closed, thin);
  if (!is_whole(result.mesh, volume)) result.mesh = {};
  return result;
}

double volume_of_union(const TriangleMesh& closed) {
  return wound_volume(closed, thinnest({closed}) / kLinesAcross, 1);
}

}  // namespace angio::meshing::detail
