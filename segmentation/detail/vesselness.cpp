#include "segmentation/detail/vesselness.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "core/parallel.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kNoiseDeviations = 5.5;
constexpr double kBlocksPerSigma = 2.5;     ///< coarse voxels per standard deviation
constexpr double kLeastSigmaVoxels = 0.9;   ///< below it, differences stand for no derivative
constexpr double kMadToDeviation = 1.4826;  ///< of a normal distribution

/// l2 at each voxel [intensity / mm^2], from central differences of a smoothed volume.
Volume<float> middle_eigenvalue(const Volume<float>& smoothed) {
  const auto [ni, nj, nk] = smoothed.geometry.size;
  const Vec3T<float> h{float(smoothed.geometry.spacing.x), float(smoothed.geometry.spacing.y),
                       float(smoothed.geometry.spacing.z)};
  Volume<float> result(smoothed.geometry);
  parallel_for(nk, [&, ni = ni, nj = nj, nk = nk](std::ptrdiff_t slice) {
    const int k = int(slice), k0 = std::max(k - 1, 0), k1 = std::min(k + 1, nk - 1);
    for (int j = 0; j < nj; ++j) {
      const int j0 = std::max(j - 1, 0), j1 = std::min(j + 1, nj - 1);
      const auto row = [&](int b, int c) { return &smoothed.at(0, b, c); };
      const float *m = row(j, k), *y0 = row(j0, k), *y1 = row(j1, k), *z0 = row(j, k0),
                  *z1 = row(j, k1), *y0z0 = row(j0, k0), *y1z0 = row(j1, k0), *y0z1 = row(j0, k1),
                  *y1z1 = row(j1, k1);
      for (int i = 0; i < ni; ++i) {
        const int i0 = std::max(i - 1, 0), i1 = std::min(i + 1, ni - 1);
        const float xx = (m[i0] - 2.0f * m[i] + m[i1]) / (h.x * h.x);
        const float yy = (y0[i] - 2.0f * m[i] + y1[i]) / (h.y * h.y);
        const float zz = (z0[i] - 2.0f * m[i] + z1[i]) / (h.z * h.z);
        const float xy = (y1[i1] - y1[i0] - y0[i1] + y0[i0]) / (4.0f * h.x * h.y);
        const float xz = (z1[i1] - z1[i0] - z0[i1] + z0[i0]) / (4.0f * h.x * h.z);
        const float yz = (y1z1[i] - y1z0[i] - y0z1[i] + y0z0[i]) / (4.0f * h.y * h.z);
        result.at(i, j, k) = symmetric_eigenvalues(xx, yy, zz, xy, xz, yz).y;
      }
    }
  });
  return result;
}

float median(std::vector<float>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Standard deviation of the bulk of the values, from every n-th of them.
double robust_deviation(std::span<const float> values) {
  constexpr std::size_t kSampleCount = 200000;
  const std::size_t step = std::max<std::size_t>(1, values.size() / kSampleCount);
  std::vector<float> sample;
  for (std::size_t v = 0; v < values.size(); v += step) sample.push_back(values[v]);
  const float centre = median(sample);
  for (float& v : sample) v = std::abs(v - centre);
  return kMadToDeviation * double(median(sample));
}

/// C at one scale, on a grid as coarse as the scale allows.
CoarseField contrast_at_scale(const Volume<float>& volume, double sigma) {
  const auto factor = block_size(volume.geometry, sigma / kBlocksPerSigma);
  Volume<float> blocks = block_average(volume, factor);
  const Vec3 h = blocks.geometry.spacing;
  // A block average blurs by h^2 / 12 beyond what a voxel holds already, a difference by h^2 / 6.
  const double blurred = dot(h, h) / 36.0 -
                         dot(volume.geometry.spacing, volume.geometry.spacing) / 36.0 +
                         dot(h, h) / 18.0;
  Volume<float> l2 =
      middle_eigenvalue(smooth(blocks, std::sqrt(std::max(sigma * sigma - blurred, 0.0))));
  const double scale = std::numbers::e * sigma * sigma;
  const auto noise = float(kNoiseDeviations * robust_deviation(l2.values));
  parallel_for(l2.geometry.size[2], [&](std::ptrdiff_t k) {
    const std::size_t slice = l2.values.size() / std::size_t(l2.geometry.size[2]);
    for (std::size_t v = std::size_t(k) * slice; v < (std::size_t(k) + 1) * slice; ++v)
      l2.values[v] = -l2.values[v] > noise ? float(scale) * -l2.values[v] : 0.0f;
  });
  return {std::move(l2), factor};
}

}  // namespace

Vec3T<float> symmetric_eigenvalues(float xx, float yy, float zz, float xy, float xz, float yz) {
  const float mean = (xx + yy + zz) / 3.0f;
  const float a = xx - mean, b = yy - mean, c = zz - mean;
  const float off = xy * xy + xz * xz + yz * yz;
  const float p = std::sqrt((a * a + b * b + c * c + 2.0f * off) / 6.0f);
  if (!(p > 0.0f)) return {mean, mean, mean};
  const float half_determinant =
      0.5f * (a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz));
  const float r = std::clamp(half_determinant / (p * p * p), -1.0f, 1.0f);
  const float angle = std::acos(r) / 3.0f;
  const float highest = mean + 2.0f * p * std::cos(angle);
  const float lowest = mean + 2.0f * p * std::cos(angle + 2.0943951f);
  return {lowest, 3.0f * mean - highest - lowest, highest};
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
