#include "meshing/detail/unite_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "air_mesh/build/surface_crossings.hpp"
#include "core/parallel.hpp"
#include "core/volume.hpp"
#include "meshing/detail/crossings.hpp"
#include "meshing/detail/isosurface.hpp"
#include "meshing/detail/level_band.hpp"
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
         std::abs(enclosed_volume(mesh) - volume) <= kSameVolume * volume;
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

/// The runs of a grid's nodes where the winding number is above 0.
GridRows runs_of_union(const Winding& winding, const VolumeGeometry& grid) {
  return rows_by_layers(grid.size[2], [&](int k, GridRows& layer) {
    for (int j = 0; j < grid.size[1]; ++j) {
      const Vec3 here = grid.lps_from_index({0.0, double(j), double(k)});
      const double next = winding.next_line(here.y, here.z);
      if (next - grid.origin.y > grid.spacing.y * grid.size[1]) break;
      j = std::max(j, int((next - grid.origin.y) / grid.spacing.y));
      const Vec3 row = grid.lps_from_index({0.0, double(j), double(k)});
      int turns = 0;
      for (const auto& [x, change] : winding.crossings(row.y, row.z)) {
        const bool was_inside = turns > 0;
        turns += change;
        if ((turns > 0) == was_inside) continue;
        layer.at.push_back(
            std::clamp(int(std::ceil((x - row.x) / grid.spacing.x)), 0, grid.size[0]));
      }
      layer.end_row(std::int64_t(k) * grid.size[1] + j);
    }
  });
}

/// Signed distance [mm] from the union's wall, two steps at most.
LevelBand union_level_set(const Winding& winding, const TriangleMesh& exposed,
                          const VolumeGeometry& grid) {
  LevelBand band = band_around(grid, runs_of_union(winding, grid));
  const ClosestPoint wall(exposed);
  const double step = grid.spacing.x;
  parallel_for_uneven(std::ptrdiff_t(band.nodes.count()), [&](std::ptrdiff_t index) {
    const auto place = std::size_t(index);
    const std::int64_t row = band.nodes.row[place];
    for (std::size_t n = band.nodes.first[place]; n < band.nodes.first[place + 1]; ++n) {
      const Vec3 node = grid.lps_from_index(
          {double(band.nodes.at[n]), double(row % grid.size[1]), double(row / grid.size[1])});
      const double distance = std::min(wall.find(node).distance, 2.0 * step);
      band.level[n] *= std::max(float(distance), 1e-6F * float(step));
    }
  });
  return band;
}

struct PartBounds {
  Vec3 low, high;
};
PartBounds box_around(const TriangleMesh& surface) {
  PartBounds box{surface.vertices.front(), surface.vertices.front()};
  for (const Vec3& p : surface.vertices)
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], p[axis]);
      box.high[axis] = std::max(box.high[axis], p[axis]);
    }
  return box;
}

VolumeGeometry grid_in(const PartBounds& box, double step) {
  constexpr double kOff = 1.234567e-4;  // steps; the lines miss the vertices of constructions
  VolumeGeometry grid;
  grid.spacing = {step, step, step};
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[std::size_t(axis)] = int((box.high[axis] - box.low[axis]) / step) + 8;
    grid.origin[axis] = box.low[axis] - (3.0 + kOff) * step;
  }
  return grid;
}

/// The step is an eighth of the thinnest part, up to a quarter where that keeps the box to 3e7
/// cells; in a larger box, where it keeps those that the wall runs through to half a million.
Union contour_union(const TriangleMesh& closed, double thin) {
  constexpr double kAcross = 8.0, kLeastAcross = 4.0;
  constexpr double kManyInBox = 3e7, kManyAtWall = 5e5, kMostAtWall = 1.2e6;  // cells
  constexpr double kMostAlong = 1e5;                                          // cells of a side
  constexpr double kTrianglesOfCell = 6.0;                                    // 4 to 8
  constexpr double kCrumb = 1e-3;                                             // of the volume
  const PartBounds box = box_around(closed);
  const Vec3 sides = box.high - box.low;
  const double of_box = std::cbrt(sides.x * sides.y * sides.z / kManyInBox);
  double step = std::clamp(of_box, thin / kAcross, thin / kLeastAcross);
  const Winding winding(closed);
  const TriangleMesh exposed = exposed_part(closed, winding, step);
  const double area = surface_area(exposed);
  if (of_box > step)
    step = std::clamp(std::sqrt(area / kManyAtWall), thin / kAcross, thin / kLeastAcross);
  if (std::max({sides.x, sides.y, sides.z}) > kMostAlong * step) return {};
  const double cell_count = area / (step * step);
  if (cell_count > kMostAtWall) return {.mesh = {}, .too_many = kTrianglesOfCell * cell_count};
  const VolumeGeometry grid = grid_in(box, step);
  const TriangleMesh contour = extract_isosurface(union_level_set(winding, exposed, grid));
  const double least = kCrumb * enclosed_volume(contour);
  std::vector<TriangleMesh> solids = connected_pieces(contour);
  std::erase_if(solids, [&](const TriangleMesh& piece) {  // crumbs, and walls of hollows inside
    return enclosed_volume(piece) < least;
  });
  return {.mesh = solids.empty() ? TriangleMesh() : joined(solids)};
}

}  // namespace

Union unite_parts(const std::vector<TriangleMesh>& parts) {
  constexpr double kTouch = 1e-3;  // of the union; less is no overlap
  const TriangleMesh closed = joined(parts);
  const double thin = thinnest(parts);
  const double volume = wound_volume(closed, thin / kLinesAcross, 1);
  Union result;
  result.mesh = parts.size() > 1 ? unite_exactly(parts) : TriangleMesh();
  if (is_whole(result.mesh, volume) && air_mesh::self_intersections(result.mesh).empty())
    return result;
  if (wound_volume(closed, thin / kLinesAcross, 2) < kTouch * volume && parts.size() > 1)
    return {.mesh = {}, .only_touch = true};
  result = contour_union(closed, thin);  // free of crossings, as isosurfaces are
  if (!is_whole(result.mesh, volume)) result.mesh = {};
  return result;
}

double volume_of_union(const TriangleMesh& closed) {
  return wound_volume(closed, thinnest({closed}) / kLinesAcross, 1);
}

}  // namespace angio::meshing::detail
