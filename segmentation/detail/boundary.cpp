#include "segmentation/detail/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/signed_distance.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr int kIterationCount = 3;
constexpr double kFieldSpacing = 1.0;                    ///< [mm] grid of L and B
constexpr double kFieldReach[] = {16.0, 8.0, 4.0, 2.0};  ///< [mm] kernels, widest first
constexpr float kPriorWeight = 0.02f;  ///< of the wider kernel against a full narrow one
constexpr double kEdgeVoxels = 2.0;    ///< half width of the blurred edge
constexpr double kRingWidth = 3.0;     ///< [mm] of background looked at
constexpr double kReachMm = 5.0;       ///< to which the level set tells distances outside
constexpr float kLeastShare = 0.2f;    ///< of the contrast: T never goes below
constexpr double kMostBlurVoxels = 1.5;
constexpr double kVoxelBudget = 32e6;  ///< of the result
constexpr float kPeakShare = 0.7f;     ///< T stays below this share of the local peak

double mean_spacing(const VolumeGeometry& geometry) {
  return std::cbrt(geometry.spacing.x * geometry.spacing.y * geometry.spacing.z);
}

/// A mean of the volume over the voxels where weight(v) > 0, told everywhere: near such voxels
/// their local mean, far from them a wider one.
template <class Weight>
CoarseField local_mean(const Volume<float>& volume, float everywhere, const Weight& weight) {
  Volume<float> weights(volume.geometry);
  Volume<float> sums(volume.geometry);
  parallel_for(volume.geometry.size[2], [&](std::ptrdiff_t k) {
    const std::size_t slice = volume.values.size() / std::size_t(volume.geometry.size[2]);
    for (std::size_t v = std::size_t(k) * slice; v < (std::size_t(k) + 1) * slice; ++v) {
      weights.values[v] = weight(v);
      sums.values[v] = weights.values[v] * volume.values[v];
    }
  });
  const auto factor = block_size(volume.geometry, kFieldSpacing);
  const Volume<float> coarse_weights = block_average(weights, factor);
  const Volume<float> coarse_sums = block_average(sums, factor);
  Volume<float> mean(coarse_weights.geometry, everywhere);
  for (double reach : kFieldReach) {
    const Volume<float> w = smooth(coarse_weights, reach);
    const Volume<float> s = smooth(coarse_sums, reach);
    for (std::size_t v = 0; v < mean.values.size(); ++v)
      mean.values[v] = (s.values[v] + kPriorWeight * mean.values[v]) / (w.values[v] + kPriorWeight);
  }
  return {std::move(mean), factor};
}

/// The mean over all voxels where weight(v) > 0, or the fallback.
template <class Weight>
float overall_mean(const Volume<float>& volume, float fallback, const Weight& weight) {
  double sum = 0.0, total = 0.0;
  for (std::size_t v = 0; v < volume.values.size(); ++v) {
    sum += double(weight(v)) * double(volume.values[v]);
    total += double(weight(v));
  }
  return total > 0.0 ? float(sum / total) : fallback;
}

/// The value that a share of the tree's voxels lies below.
float quantile_in(const Volume<float>& volume, const std::vector<float>& distance, double share) {
  std::vector<float> values;
  for (std::size_t v = 0; v < distance.size(); ++v)
    if (distance[v] < 0.0f) values.push_back(volume.values[v]);
  if (values.empty()) return 0.0f;
  const auto place = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// The highest value within two voxels.
Volume<float> local_peak(const Volume<float>& volume) {
  constexpr int kReach = 2;
  Volume<float> peak = volume;
  const auto size = volume.geometry.size;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Volume<float> before = peak;
    parallel_for(size[2], [&](std::ptrdiff_t k) {
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i) {
          std::array<int, 3> voxel{i, j, int(k)};
          const int middle = voxel[axis];
          float highest = before.at(i, j, int(k));
          for (int t = std::max(0, middle - kReach); t <= std::min(size[axis] - 1, middle + kReach);
               ++t) {
            voxel[axis] = t;
            highest = std::max(highest, before.at(voxel[0], voxel[1], voxel[2]));
          }
          peak.at(i, j, int(k)) = highest;
        }
    });
  }
  return peak;
}

/// The inverse of the standard normal distribution, by bisection.
double normal_quantile(double share) {
  double low = -8.0, high = 8.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Levels {
  CoarseField lumen;
  CoarseField background;
  float lumen_overall;
  float background_overall;
};

/// L and B, told from a signed distance to the boundary as known so far.
Levels local_levels(const Volume<float>& volume, const Volume<float>& distance) {
  const auto edge = float(kEdgeVoxels * mean_spacing(volume.geometry));
  const auto& d = distance.values;
  const auto deep = [&](std::size_t v) {
    return std::clamp((-d[v] - 0.75f * edge) / (0.5f * edge), 0.0f, 1.0f);
  };
  const float lumen = overall_mean(volume, quantile_in(volume, d, 0.9), deep);
  const auto ring = [&](std::size_t v) {
    return d[v] > edge && d[v] < edge + float(kRingWidth) ? 1.0f : 0.0f;
  };
  const float mixed = overall_mean(volume, quantile_in(volume, d, 0.0), ring);
  const float half = 0.5f * (lumen + mixed);
  // Other bright things nearby are no background.
  const auto dark_ring = [&](std::size_t v) { return volume.values[v] < half ? ring(v) : 0.0f; };
  const float background = overall_mean(volume, mixed, dark_ring);
  return {local_mean(volume, lumen, deep), local_mean(volume, background, dark_ring), lumen,
          background};
}

/// -F: negative where the voxel is more than half lumen.
Volume<float> level_function(const Volume<float>& volume, const Volume<float>& peak,
                             const Levels& levels, const SegmentationOptions& options) {
  const float least_contrast = 0.1f * (levels.lumen_overall - levels.background_overall);
  const auto lowest = float(options.intensity_min.value_or(-1e30));
  const auto highest = float(options.intensity_max.value_or(1e30));
  Volume<float> level(volume.geometry);
  const auto [ni, nj, nk] = volume.geometry.size;
  parallel_for(nk, [&, ni = ni, nj = nj](std::ptrdiff_t k) {
    const auto width = std::size_t(ni);
    std::vector<float> lumen(width), background(width);
    for (int j = 0; j < nj; ++j) {
      levels.lumen.row(j, int(k), ni, lumen.data());
      levels.background.row(j, int(k), ni, background.data());
      for (int i = 0; i < ni; ++i) {
        const float b = background[std::size_t(i)];
        const float contrast = std::max(lumen[std::size_t(i)] - b, least_contrast);
        const float half = b + 0.5f * contrast;
        const float below_peak = b + kPeakShare * (peak.at(i, j, int(k)) - b);
        const float threshold =
            std::max({std::min(half, below_peak), b + kLeastShare * contrast, lowest});
        const float value = volume.at(i, j, int(k));
        float excess = (value - threshold) / contrast;
        if (value > highest) excess = -0.5f;
        level.at(i, j, int(k)) = -std::clamp(excess, -1.0f, 1.0f);
      }
    }
  });
  return level;
}

/// Turns all pieces but one into outside, and closed holes into inside.
/// @param weight  the piece with most of it stays; shape [voxel_count]
template <class Weight>
void keep_piece(Volume<float>& level, const Weight& weight) {
  Volume<std::uint8_t> inside(level.geometry);
  for (std::size_t v = 0; v < level.values.size(); ++v) inside.values[v] = level.values[v] < 0.0f;
  const Components pieces = label_components(inside, Connectivity::faces);
  std::vector<std::size_t> overlap(std::size_t(pieces.count()) + 1, 0);
  for (std::size_t v = 0; v < level.values.size(); ++v)
    if (pieces.label[v] > 0 && weight(v)) ++overlap[std::size_t(pieces.label[v])];
  const auto kept =
      std::int32_t(std::max_element(overlap.begin(), overlap.end()) - overlap.begin());
  for (std::size_t v = 0; v < level.values.size(); ++v) {
    if (pieces.label[v] > 0 && pieces.label[v] != kept) level.values[v] = -level.values[v];
    inside.values[v] = level.values[v] >= 0.0f;
  }
  const Components holes = label_components(inside, Connectivity::faces);
  const auto outside = std::max_element(holes.voxel_count.begin(), holes.voxel_count.end()) -
                       holes.voxel_count.begin();
  for (std::size_t v = 0; v < level.values.size(); ++v)
    if (holes.label[v] > 0 && holes.label[v] != outside)
      level.values[v] = -std::max(level.values[v], 1e-3f);
}

/// Standard deviation [mm] of the blur across the boundary: the level follows the blurred step
/// u = Phi(-d / sigma), so that the normal quantile of its mean at each distance is a line in d.
double blur_across(const Volume<float>& level, const Volume<float>& distance) {
  constexpr int kBinCount = 41;
  const double h = mean_spacing(level.geometry);
  const double width = 2.0 * h / kBinCount;
  std::vector<double> sum(kBinCount, 0.0), count(kBinCount, 0.0);
  for (std::size_t v = 0; v < level.values.size(); ++v) {
    const int bin = int(std::floor(double(distance.values[v]) / width + 0.5 * kBinCount));
    if (bin < 0 || bin >= kBinCount) continue;
    sum[std::size_t(bin)] += 0.5 - double(level.values[v]);
    count[std::size_t(bin)] += 1.0;
  }
  double zd = 0.0, dd = 0.0;
  for (std::size_t b = 0; b < sum.size(); ++b) {
    if (count[b] < 10.0) continue;
    const double share = sum[b] / count[b];
    if (share < 0.2 || share > 0.8) continue;
    const double d = (double(b) + 0.5 - 0.5 * kBinCount) * width;
    zd += count[b] * normal_quantile(share) * d;
    dd += count[b] * d * d;
  }
  const double slope = dd > 0.0 ? -zd / dd : 0.0;  // 1 / sigma
  return std::clamp(slope > 0.0 ? 1.0 / slope : 0.0, 0.0, kMostBlurVoxels * h);
}

/// Undoes the inward shift of the half level of a blurred bent surface:
///
///     d <- d - sigma^2 / 2 (k1 + k2),    k1 + k2 = laplace d
///
/// which is its first order in sigma k; at most half of sigma is given back.
Volume<float> undo_blur(const Volume<float>& distance, double sigma, double smoothing) {
  const Volume<float> smoothed = smooth(distance, smoothing);
  const auto [ni, nj, nk] = distance.geometry.size;
  const Vec3 h = distance.geometry.spacing;
  const auto band = float(3.0 * std::max({h.x, h.y, h.z}));
  Volume<float> result = distance;
  parallel_for(nk - 2, [&, ni = ni, nj = nj](std::ptrdiff_t slice) {
    const int k = int(slice) + 1;
    for (int j = 1; j + 1 < nj; ++j)
      for (int i = 1; i + 1 < ni; ++i) {
        if (std::abs(distance.at(i, j, k)) > band) continue;
        const float twice = 2.0f * smoothed.at(i, j, k);
        const double curvature =
            double(smoothed.at(i - 1, j, k) + smoothed.at(i + 1, j, k) - twice) / (h.x * h.x) +
            double(smoothed.at(i, j - 1, k) + smoothed.at(i, j + 1, k) - twice) / (h.y * h.y) +
            double(smoothed.at(i, j, k - 1) + smoothed.at(i, j, k + 1) - twice) / (h.z * h.z);
        result.at(i, j, k) -= float(0.5 * sigma * std::clamp(sigma * curvature, -1.0, 1.0));
      }
  });
  return result;
}

/// The spacing of the result: even along all axes, and as fine as half the input's finest if that
/// keeps the grid within a budget, so that narrow vessels keep their shape.
Vec3 fine_spacing(const VolumeGeometry& geometry) {
  const Vec3& h = geometry.spacing;
  const double finest = std::min({h.x, h.y, h.z});
  const double volume = double(geometry.voxel_count()) * h.x * h.y * h.z;
  const double affordable = std::cbrt(volume / kVoxelBudget);
  const double even = std::max(0.5 * finest, affordable);
  return even < 0.8 * finest                                  ? Vec3{even, even, even}
         : even < finest || h == Vec3{finest, finest, finest} ? Vec3{finest, finest, finest}
                                                              : h;
}

}  // namespace

Boundary find_boundary(const Volume<float>& volume, const Volume<std::uint8_t>& tree,
                       const SegmentationOptions& options, const Progress& progress) {
  Volume<float> level(volume.geometry);
  for (std::size_t v = 0; v < level.values.size(); ++v)
    level.values[v] = tree.values[v] ? -0.5f : 0.5f;
  const Volume<float> peak = local_peak(volume);
  Boundary boundary;
  for (int iteration = 0; iteration < kIterationCount; ++iteration) {
    const Levels levels = local_levels(volume, signed_distance(level, kReachMm));
    level = level_function(volume, peak, levels, options);
    keep_piece(level, [&](std::size_t v) { return tree.values[v] != 0; });
    boundary.lumen_intensity = double(levels.lumen_overall);
    boundary.background_intensity = double(levels.background_overall);
    progress.report(0.6 + 0.1 * (iteration + 1), "finding the boundary");
  }
  const double blur = blur_across(level, signed_distance(level, kReachMm));
  const double voxel = mean_spacing(level.geometry);
  level = resample_cubic(level, fine_spacing(level.geometry));
  keep_piece(level, [](std::size_t) { return true; });
  level = undo_blur(signed_distance(level, kReachMm), blur, voxel);
  progress.report(0.95, "finding the boundary");
  boundary.level_set = signed_distance(level, kReachMm);
  boundary.blur_mm = blur;
  return boundary;
}

}  // namespace angio::segmentation::detail
