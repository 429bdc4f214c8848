#include "segmentation/detail/intensity_levels.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/parallel.hpp"
#include "segmentation/detail/local_mean.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kRingWidth = 3.0;   ///< [mm] of background looked at
constexpr float kLeastShare = 0.5f;  ///< of lumen in a voxel that tells of L

/// The mean of value(v) over all voxels where weight(v) > 0, or the fallback.
template <class Value, class Weight>
float overall_mean(const VolumeGeometry& grid, float fallback, const Value& value,
                   const Weight& weight) {
  struct Sums {
    double sum = 0.0, total = 0.0;
  };
  std::vector<Sums> slices(std::size_t(grid.size[2]), Sums{});
  const std::size_t slice = grid.voxel_count() / slices.size();
  parallel_for(grid.size[2], [&](std::ptrdiff_t k) {
    Sums part;
    for (std::size_t v = std::size_t(k) * slice; v < std::size_t(k + 1) * slice; ++v) {
      const double w = double(weight(v));
      if (w <= 0.0) continue;
      part.sum += w * double(value(v));
      part.total += w;
    }
    slices[std::size_t(k)] = part;
  });
  Sums all;
  for (const Sums& part : slices) {
    all.sum += part.sum;
    all.total += part.total;
  }
  return all.total > 0.0 ? float(all.sum / all.total) : fallback;
}

std::vector<float> values_inside(const Volume<float>& volume, const Volume<float>& distance) {
  std::vector<float> values;
  for (std::size_t v = 0; v < distance.values.size(); ++v)
    if (distance.values[v] < 0.0f) values.push_back(volume.values[v]);
  return values;
}

/// The value that a share of the values lies below.
float quantile(std::vector<float>& values, double share) {
  if (values.empty()) return 0.0f;
  const auto place = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

constexpr float kLeastFilled = 150.0f;  ///< [HU] of blood with contrast medium

/// Whether a volume shows a body in Hounsfield units: fat and soft tissue, each a fiftieth of it
/// and fat at least half as common as what lies between, around a vessel as bright as contrast
/// medium makes it.
bool is_body(const Volume<float>& volume, float lumen) {
  constexpr float kMostFilled = 1200.0f;
  constexpr double kLeastShare = 0.02, kMostBetween = 0.5;  // of as many units as fat's
  if (lumen < kLeastFilled || lumen > kMostFilled) return false;
  const auto count = [&](float low, float high) {
    return double(std::count_if(volume.values.begin(), volume.values.end(),
                                [&](float value) { return value > low && value < high; }));
  };
  const double least = kLeastShare * double(volume.values.size());
  const double fat = count(-130.0f, -70.0f);
  return fat > least && count(20.0f, 130.0f) > least && fat > kMostBetween * count(-50.0f, 10.0f);
}

/// How far a wall of a thickness is seen as the background: erf(t / (sqrt(2) s)), as the header
/// says.
double seen_wall(double thickness, double blur_sd) {
  return std::erf(thickness / (std::numbers::sqrt2 * blur_sd));
}

/// By how much the background beside a vessel has to be lifted, for its wall to be background.
struct WallLift {
  const BloodLevel* blood = nullptr;  ///< told by even places: wide vessels' walls are lifted
  bool is_body = false;               ///< walls in fat are lifted
  double voxel_mm = 1.0, blur_sd_mm = 1.0;

  /// @param depth  of the vessel nearby [mm], 0.8 of its radius
  [[nodiscard]] float of(float background, float lumen, float depth) const {
    return std::max(beside_wide(background, depth), in_fat(background, lumen, depth));
  }

 private:
  [[nodiscard]] float beside_wide(float background, float depth) const {
    constexpr float kUnseen = 2.5f, kSeen = 4.2f;  // voxels of depth
    constexpr float kDarker = 0.25f;               // of the contrast: fat
    if (!blood) return 0.0f;
    const float wall = blood->tissue - kDarker * blood->contrast();
    const float voxels = depth / float(voxel_mm);
    const float part = std::clamp((voxels - kUnseen) / (kSeen - kUnseen), 0.0f, 1.0f);
    return part * std::max(0.0f, wall - background);
  }

  [[nodiscard]] float in_fat(float background, float lumen, float depth) const {
    constexpr float kWall = 50.0f;                     // [HU]
    constexpr float kNoFat = -250.0f, kFat = -120.0f;  // [HU]: with more air or lung than fat
    constexpr double kThickness = 0.4 / 0.8;           // of the depth: 0.4 of the radius
    constexpr double kLeastThickness = 0.55;           // [mm]
    if (!is_body || lumen < kLeastFilled || background >= kWall) return 0.0f;
    const float part = std::clamp((background - kNoFat) / (kFat - kNoFat), 0.0f, 1.0f);
    const double thickness = std::max(kThickness * double(depth), kLeastThickness);
    return part * float(seen_wall(thickness, blur_sd_mm)) * (kWall - background);
  }
};

/// @param depth  of the vessel nearby [mm]
/// @param lift   gets by how much
void lift_by_walls(const WallLift& wall, const CoarseField& depth, const CoarseField& lumen,
                   CoarseField& background, CoarseField& lift) {
  Volume<float> lifted = background.coarse(), by(lifted.geometry, 0.0f);
  for (std::size_t v = 0; v < lifted.values.size(); ++v) {
    by.values[v] = wall.of(lifted.values[v], lumen.coarse().values[v], depth.coarse().values[v]);
    lifted.values[v] += by.values[v];
  }
  background = {std::move(lifted), background.factor()};
  lift = {std::move(by), background.factor()};
}

}  // namespace

IntensityLevels intensity_levels(const Volume<float>& volume, const Volume<float>& distance,
                                 const Volume<float>& share, double edge_mm,
                                 const std::optional<BloodLevel>& blood) {
  const VolumeGeometry& grid = volume.geometry;
  const auto edge = float(edge_mm);
  const auto& d = distance.values;
  const auto intensity = [&](std::size_t v) { return volume.values[v]; };
  const auto ring = [&](std::size_t v) {
    return d[v] > edge && d[v] < edge + float(kRingWidth) ? 1.0f : 0.0f;
  };
  std::vector<float> inside = values_inside(volume, distance);
  const float high = quantile(inside, 0.9);
  const float mixed = overall_mean(grid, quantile(inside, 0.0), intensity, ring);
  const float half = std::max(0.5f * (high + mixed), blood ? blood->half() : -1e30f);
  // Other bright things nearby are no background.
  const auto dark_ring = [&](std::size_t v) { return volume.values[v] < half ? ring(v) : 0.0f; };
  const float background = overall_mean(grid, mixed, intensity, dark_ring);

  const auto weight = [&](std::size_t v) {
    const float s = share.values[v];
    const float s4 = s * s * s * s;
    const float s8 = s4 * s4;
    return s > kLeastShare ? s8 * s8 * s8 : 0.0f;
  };
  const auto unmixed = [&](std::size_t v) {
    return background + (volume.values[v] - background) / share.values[v];
  };
  const float lumen = overall_mean(grid, high, unmixed, weight);
  CoarseField around = local_mean(grid, background, intensity, dark_ring);
  CoarseField filled = local_mean(grid, lumen, unmixed, weight);
  CoarseField lift(Volume<float>(around.coarse().geometry, 0.0f), around.factor());
  const WallLift wall{blood && blood->is_even ? &*blood : nullptr, is_body(volume, lumen),
                      mean_spacing(grid), edge_mm / kEdgeBlurs};
  if (wall.blood || wall.is_body) {
    const auto depth = [&](std::size_t v) { return -d[v]; };
    const auto deep = [&](std::size_t v) {  // the deepest have the say
      const float squared = d[v] * d[v];
      return d[v] < 0.0f ? squared * squared * squared * squared : 0.0f;
    };
    lift_by_walls(wall, local_mean(grid, 0.0f, depth, deep), filled, around, lift);
  }
  return {std::move(filled), std::move(around), std::move(lift), lumen, background};
}

}  // namespace angio::segmentation::detail
