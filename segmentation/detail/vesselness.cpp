#include "segmentation/detail/vesselness.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "core/parallel.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/hessian.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kBlocksPerSigma = 2.5;     ///< coarse voxels per standard deviation
constexpr double kLeastSigmaVoxels = 0.9;   ///< below it, differences stand for no derivative
constexpr double kMadToDeviation = 1.4826;  ///< of a normal distribution

/// l2 at each voxel [intensity / mm^2], from central differences of a smoothed volume.
Volume<float> middle_eigenvalue(const Volume<float>& smoothed) {
  const auto [ni, nj, nk] = smoothed.geometry.size;
  Volume<float> result(smoothed.geometry);
  parallel_for(nk, [&, ni = ni, nj = nj](std::ptrdiff_t k) {
    RowEigenvalues eigenvalues(ni);
    for (int j = 0; j < nj; ++j) {
      RowDifferences(smoothed, j, int(k)).find(eigenvalues);
      std::copy(eigenvalues.middle.begin(), eigenvalues.middle.end(), &result.at(0, j, int(k)));
    }
  });
  return result;
}

float median(std::vector<float>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// C at one scale, on a grid as coarse as the scale allows.
CoarseField contrast_at_scale(const Volume<float>& volume, double sigma) {
  ScaleView view = view_at_scale(volume, sigma);
  Volume<float> l2 = middle_eigenvalue(view.smoothed);
  const double scale = std::numbers::e * sigma * sigma;
  const auto noise = float(kNoiseDeviations * robust_deviation(l2.values));
  parallel_for(l2.geometry.size[2], [&](std::ptrdiff_t k) {
    const std::size_t slice = l2.values.size() / std::size_t(l2.geometry.size[2]);
    for (std::size_t v = std::size_t(k) * slice; v < (std::size_t(k) + 1) * slice; ++v)
      l2.values[v] = -l2.values[v] > noise ? float(scale) * -l2.values[v] : 0.0f;
  });
  return {std::move(l2), view.factor};
}

}  // namespace

double robust_deviation(std::span<const float> values) {
  constexpr std::size_t kSampleCount = 200000;
  const std::size_t step = std::max<std::size_t>(1, values.size() / kSampleCount);
  std::vector<float> sample;
  for (std::size_t v = 0; v < values.size(); v += step) sample.push_back(values[v]);
  const float centre = median(sample);
  for (float& v : sample) v = std::abs(v - centre);
  return kMadToDeviation * double(median(sample));
}

ScaleView view_at_scale(const Volume<float>& volume, double sigma) {
  const auto factor = block_size(volume.geometry, sigma / kBlocksPerSigma);
  const Volume<float> blocks = block_average(volume, factor);
  const Vec3 h = blocks.geometry.spacing;
  // A block average blurs by h^2 / 12 beyond what a voxel holds already, a difference by h^2 / 6.
  const double blurred = dot(h, h) / 36.0 -
                         dot(volume.geometry.spacing, volume.geometry.spacing) / 36.0 +
                         dot(h, h) / 18.0;
  return {smooth(blocks, std::sqrt(std::max(sigma * sigma - blurred, 0.0))), factor};
}

Volume<float> tube_contrast(const Volume<float>& volume, const std::vector<double>& radii_mm,
                            const Progress& progress) {
  const Vec3 h = volume.geometry.spacing;
  const double voxel = std::cbrt(h.x * h.y * h.z);
  Volume<float> best(volume.geometry, 0.0f);
  for (std::size_t s = 0; s < radii_mm.size(); ++s) {
    const double sigma = std::max(radii_mm[s] / std::numbers::sqrt2, kLeastSigmaVoxels * voxel);
    const CoarseField contrast = contrast_at_scale(volume, sigma);
    parallel_for(best.geometry.size[2], [&](std::ptrdiff_t k) {
      std::vector<float> row(std::size_t(best.geometry.size[0]));
      for (int j = 0; j < best.geometry.size[1]; ++j) {
        contrast.row(j, int(k), best.geometry.size[0], row.data());
        float* out = &best.at(0, j, int(k));
        for (std::size_t i = 0; i < row.size(); ++i) out[i] = std::max(out[i], row[i]);
      }
    });
    progress.report(0.3 * double(s + 1) / double(radii_mm.size()), "enhancing vessels");
  }
  return best;
}

}  // namespace angio::segmentation::detail
