#include "meshing/calcium.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/statistics.hpp"
#include "core/tet_mesh.hpp"

namespace angio::meshing {
namespace {

/// First and last voxel around points, one index each; within the grid.
std::array<std::array<int, 3>, 2> voxels_around(const VolumeGeometry& grid,
                                                const std::vector<Vec3>& points) {
  std::array<std::array<int, 3>, 2> box{grid.size, {0, 0, 0}};
  for (const Vec3& p : points) {
    const Vec3 index = grid.index_from_lps(p);
    for (std::size_t a = 0; a < 3; ++a) {
      const int last = grid.size[a] - 1;
      box[0][a] = std::min(box[0][a], std::clamp(int(std::floor(index[int(a)])), 0, last));
      box[1][a] = std::max(box[1][a], std::clamp(int(std::ceil(index[int(a)])), 0, last));
    }
  }
  return box;
}

}  // namespace

std::optional<CalciumLevel> measure_calcium_level(const Volume<float>& scan,
                                                  const Volume<float>& level_set,
                                                  const WallLayers& wall) {
  constexpr std::size_t kEnough = 100;
  constexpr double kOfNormal = 1.4826;
  const VolumeGeometry& grid = scan.geometry;
  if (wall.vertices.empty()) return std::nullopt;
  const double voxel = grid.longest_spacing();
  const auto [first, last] = voxels_around(grid, wall.vertices);
  std::vector<float> blood;
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i)
        if (interpolate(level_set, grid.lps_from_index({double(i), double(j), double(k)})) < -voxel)
          blood.push_back(scan.at(i, j, k));
  if (blood.size() < kEnough) return std::nullopt;
  const float middle = median(blood);
  for (float& value : blood) value = std::abs(value - middle);
  return CalciumLevel{middle, kOfNormal * double(median(std::move(blood)))};
}

double mark_calcium(const Volume<float>& scan, const CalciumLevel& level, WallLayers& wall) {
  double volume = 0.0;
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    if (wall.tissue[w] != WallTissue::plaque && wall.tissue[w] != WallTissue::intima) continue;
    std::array<Vec3, 6> x;
    Vec3 centre;
    for (std::size_t c = 0; c < 6; ++c) {
      x[c] = wall.vertices[std::size_t(wall.wedges[w][c])];
      centre += (1.0 / 6.0) * x[c];
    }
    if (!(interpolate(scan, centre) > level.threshold())) continue;
    wall.tissue[w] = WallTissue::calcium;
    volume += cut_wedge_volume(x);
  }
  return volume;
}

}  // namespace angio::meshing
