#include "segmentation/detail/blur.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kMostBlurVoxels = 1.5;

}  // namespace

double mean_spacing(const VolumeGeometry& geometry) {
  return std::cbrt(geometry.spacing.x * geometry.spacing.y * geometry.spacing.z);
}

double normal_quantile(double share) {
  double low = -8.0, high = 8.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

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

Volume<float> undo_blur(const Volume<float>& distance, double sigma_mm, double smoothing_mm) {
  const Volume<float> smoothed = smooth(distance, smoothing_mm);
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
        result.at(i, j, k) -= float(0.5 * sigma_mm * std::clamp(sigma_mm * curvature, -1.0, 1.0));
      }
  });
  return result;
}

}  // namespace angio::segmentation::detail
