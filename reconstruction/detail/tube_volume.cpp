#include "reconstruction/detail/tube_volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/error.hpp"

namespace angio::reconstruction::detail {
namespace {

/// A piece of a tube between two points of a line.
struct Piece {
  Vec3 from, to;
  double from_radius = 0.0, to_radius = 0.0;
  std::size_t path = 0;
  std::vector<std::size_t> cuts = {};  ///< its own path's ends that are near
};

/// Where a line ends, and the way out of it, unit.
struct LineEnd {
  Vec3 place, outward;
  double radius = 0.0;
  std::size_t path = 0;
};

std::vector<LineEnd> ends_of(const CenterlineTree& tree) {
  std::vector<LineEnd> ends;
  const auto add = [&](std::size_t index, std::size_t end, std::size_t before) {
    const CenterlinePath& path = tree.paths[index];
    ends.push_back({path.points[end], normalized(path.points[end] - path.points[before]),
                    path.equivalent_radius[end], index});
  };
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    const std::size_t count = tree.paths[p].points.size();
    if (count < 2) continue;
    if (ends.empty()) add(p, 0, 1);  // all begin there
    add(p, count - 1, count - 2);
  }
  return ends;
}

std::vector<Piece> pieces_of(const CenterlineTree& tree) {
  std::vector<Piece> pieces;
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    const CenterlinePath& path = tree.paths[p];
    std::size_t shared = 0;  // points of an earlier path
    for (std::size_t q = 0; q < p; ++q) {
      const auto& other = tree.paths[q].points;
      std::size_t n = 0;
      while (n < std::min(other.size(), path.points.size()) && other[n] == path.points[n]) ++n;
      shared = std::max(shared, n);
    }
    for (std::size_t n = std::max<std::size_t>(shared, 1); n < path.points.size(); ++n)
      pieces.push_back({path.points[n - 1], path.points[n], path.equivalent_radius[n - 1],
                        path.equivalent_radius[n], p});
  }
  constexpr double kNear = 2.0;  // radii
  const std::vector<LineEnd> ends = ends_of(tree);
  for (Piece& piece : pieces)
    for (std::size_t e = 0; e < ends.size(); ++e)
      if (ends[e].path == piece.path &&
          std::min(distance(piece.from, ends[e].place), distance(piece.to, ends[e].place)) <
              kNear * ends[e].radius)
        piece.cuts.push_back(e);
  return pieces;
}

/// Outside the piece positive [mm].
double signed_distance(const Piece& piece, const std::vector<LineEnd>& ends, const Vec3& x) {
  const Vec3 along = piece.to - piece.from;
  const double length = norm(along);
  if (!(length > 0.0)) return std::numeric_limits<double>::infinity();
  const double t = dot(x - piece.from, along) / (length * length);
  const double inside = std::clamp(t, 0.0, 1.0);
  const double radius = (1.0 - inside) * piece.from_radius + inside * piece.to_radius;
  double away = norm(x - (piece.from + inside * along)) - radius;
  for (const std::size_t e : piece.cuts)
    away = std::max(away, dot(x - ends[e].place, ends[e].outward));
  return away;
}

VolumeGeometry grid_around(const std::vector<Piece>& pieces, double voxel_mm, int largest_side) {
  constexpr double kMargin = 4.0;  // voxels
  Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  for (const Piece& piece : pieces)
    for (const auto& [point, radius] :
         {std::pair{piece.from, piece.from_radius}, std::pair{piece.to, piece.to_radius}})
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], point[axis] - radius);
        high[axis] = std::max(high[axis], point[axis] + radius);
      }
  const double longest = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  const double voxel = std::max(voxel_mm, longest / (largest_side - 2.0 * kMargin - 1.0));
  VolumeGeometry grid;
  grid.spacing = {voxel, voxel, voxel};
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[std::size_t(axis)] =
        int(std::ceil((high[axis] - low[axis]) / voxel + 2.0 * kMargin)) + 1;
    grid.origin[axis] = low[axis] - kMargin * voxel;
  }
  return grid;
}

}  // namespace

VolumeGeometry tube_grid(const CenterlineTree& tree, double voxel_mm, int largest_side) {
  return grid_around(pieces_of(tree), voxel_mm, largest_side);
}

Volume<float> tube_volume(const CenterlineTree& tree, double value, double voxel_mm,
                          int largest_side) {
  const std::vector<Piece> pieces = pieces_of(tree);
  ANGIO_EXPECT(!pieces.empty() && voxel_mm > 0.0 && largest_side >= 16);
  const std::vector<LineEnd> ends = ends_of(tree);
  Volume<float> volume(grid_around(pieces, voxel_mm, largest_side), 0.0F);
  const VolumeGeometry& grid = volume.geometry;
  const double h = grid.spacing.x;
  for (const Piece& piece : pieces) {
    const double reach = std::max(piece.from_radius, piece.to_radius) + 0.5 * h;
    std::array<int, 3> first{}, last{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = std::size_t(axis);
      const double low = std::min(piece.from[axis], piece.to[axis]) - reach - grid.origin[axis],
                   high = std::max(piece.from[axis], piece.to[axis]) + reach - grid.origin[axis];
      first[a] = std::max(0, int(std::floor(low / h)));
      last[a] = std::min(grid.size[a] - 1, int(std::ceil(high / h)));
    }
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i) {
          const double away =
              signed_distance(piece, ends, grid.origin + h * Vec3{double(i), double(j), double(k)});
          float& voxel = volume.values[grid.offset(i, j, k)];
          voxel = std::max(voxel, float(value * std::clamp(0.5 - away / h, 0.0, 1.0)));
        }
  }
  return volume;
}

}  // namespace angio::reconstruction::detail
