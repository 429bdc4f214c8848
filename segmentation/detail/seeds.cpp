#include "segmentation/detail/seeds.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

/// What blood may be as bright as, if the seed lies in it: its tube is not darker than half way
/// from tissue to that. None where the seed lies in no tube of full profile.
std::optional<float> brightest_beside(const Vec3& seed, const std::vector<TubeAxis>& axes,
                                      const VolumeGeometry& grid) {
  std::optional<float> brightest;
  double nearest = 1.0;  // radii
  for (const TubeAxis& axis : axes)
    for (std::size_t n = 0; n < axis.voxels.size(); ++n) {
      const double away = distance(place_of_voxel(grid, axis.voxels[n]), seed) / axis.radius_mm;
      if (away >= nearest) continue;
      nearest = away;
      brightest = axis.intensity[n] + axis.contrast[n];
    }
  return brightest;
}

}  // namespace

std::vector<TubeAxis> axes_of_seeds(std::vector<TubeAxis> axes, const VolumeGeometry& grid,
                                    const std::vector<Vec3>& seeds) {
  std::optional<float> most;
  for (const Vec3& seed : seeds) most = std::max(most, brightest_beside(seed, axes, grid));
  if (!most) return axes;
  return parts_of(axes,
                  [&](const TubeAxis& axis, std::size_t n) { return axis.intensity[n] <= *most; });
}

std::optional<std::size_t> voxel_at(const VolumeGeometry& grid, const Vec3& place) {
  const Vec3 index = grid.index_from_lps(place);
  const int i = int(std::lround(index.x)), j = int(std::lround(index.y)),
            k = int(std::lround(index.z));
  if (!grid.contains(i, j, k)) return std::nullopt;
  return grid.offset(i, j, k);
}

int piece_at_seed(const Components& pieces, const VolumeGeometry& geometry, const Vec3& seed) {
  const Vec3 index = geometry.index_from_lps(seed);
  const std::string where = "the seed at " + format_place(seed);
  const int i = int(std::lround(index.x)), j = int(std::lround(index.y)),
            k = int(std::lround(index.z));
  if (!geometry.contains(i, j, k))
    throw InputError(where + " lies outside the volume (seeds are in LPS). Correct it");
  constexpr double kSeedReach = 1.0;  // [mm] a seed may miss its vessel by this
  int best = 0;
  double best_distance = kSeedReach;
  const auto reach = [&](int axis) { return int(std::ceil(kSeedReach / geometry.spacing[axis])); };
  for (int c = k - reach(2); c <= k + reach(2); ++c)
    for (int b = j - reach(1); b <= j + reach(1); ++b)
      for (int a = i - reach(0); a <= i + reach(0); ++a) {
        if (!geometry.contains(a, b, c)) continue;
        const int label = pieces.label[geometry.offset(a, b, c)];
        const double d = distance(geometry.lps_from_index({double(a), double(b), double(c)}), seed);
        if (label > 0 && (d < best_distance || (a == i && b == j && c == k))) {
          best = label;
          best_distance = d;
        }
      }
  if (best == 0)
    throw SeedInNoVessel(
        where +
        " lies in no vessel (nothing tubular and bright is there). Move it, or leave "
        "seeds out");
  return best;
}

}  // namespace angio::segmentation::detail
