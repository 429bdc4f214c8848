#include "segmentation/detail/seeds.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

/// Of a tube's contrast: contrast thins out along a tree; bone and metal beside it differ by more.
constexpr float kAlike = 0.45f;

/// On the axis of the tube that a seed lies in, else at the seed; none outside the volume.
std::optional<float> brightness_at(const Vec3& seed, const std::vector<TubeAxis>& axes,
                                   const Volume<float>& volume) {
  std::optional<float> brightness;
  double nearest = 1.0;  // radii
  for (const TubeAxis& axis : axes)
    for (std::size_t n = 0; n < axis.voxels.size(); ++n) {
      const double away =
          distance(place_of_voxel(volume.geometry, axis.voxels[n]), seed) / axis.radius_mm;
      if (away >= nearest) continue;
      nearest = away;
      brightness = axis.intensity[n];
    }
  if (brightness) return brightness;
  const auto at = voxel_at(volume.geometry, seed);
  return at ? std::optional(volume.values[*at]) : std::nullopt;
}

}  // namespace

std::vector<TubeAxis> axes_at_seeds(std::vector<TubeAxis> axes, const Volume<float>& volume,
                                    const std::vector<Vec3>& seeds) {
  std::vector<float> brightness;
  for (const Vec3& seed : seeds)
    if (const auto here = brightness_at(seed, axes, volume)) brightness.push_back(*here);
  std::vector<TubeAxis> alike = parts_of(axes, [&](const TubeAxis& axis, std::size_t n) {
    return std::ranges::any_of(brightness, [&](float here) {
      return std::abs(axis.intensity[n] - here) < kAlike * axis.contrast[n];
    });
  });
  return alike.empty() ? std::move(axes) : alike;
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
    throw InputError(where +
                     " lies in no vessel (nothing tubular and bright is there). Move it, or leave "
                     "seeds out");
  return best;
}

}  // namespace angio::segmentation::detail
