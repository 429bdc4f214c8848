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
    for (int j = 0; j < nj; ++j) {
      const RowDifferences differences(smoothed, j, int(k));
      float* out = &result.at(0, j, int(k));
      for (int i = 0; i < ni; ++i) out[i] = differences.eigenvalues(i).y;
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

struct CosineSine {
  float cosine, sine;
};

/// Cosine and sine of acos(r) / 3 for r in [0, 1], to 1e-7, without the library's calls.
///
/// acos r = sqrt(1 - r) times a polynomial: Abramowitz & Stegun, Handbook of Mathematical
/// Functions, 4.4.46; the angle is at most pi / 6, so short series do for the rest.
CosineSine third_of_arc_cosine(float r) {
  float polynomial = -0.0012624911f;
  for (const float c : {0.0066700901f, -0.0170881256f, 0.0308918810f, -0.0501743046f, 0.0889789874f,
                        -0.2145988016f, 1.5707963050f})
    polynomial = polynomial * r + c;
  const float angle = std::sqrt(1.0f - r) * polynomial / 3.0f;
  const float a = angle * angle;
  return {1.0f + a * (-0.5f + a * (1.0f / 24.0f + a * (-1.0f / 720.0f + a / 40320.0f))),
          angle * (1.0f + a * (-1.0f / 6.0f + a * (1.0f / 120.0f - a / 5040.0f)))};
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

Vec3T<float> symmetric_eigenvalues(float xx, float yy, float zz, float xy, float xz, float yz) {
  const float mean = (xx + yy + zz) / 3.0f;
  const float a = xx - mean, b = yy - mean, c = zz - mean;
  const float off = xy * xy + xz * xz + yz * yz;
  const float p = std::sqrt((a * a + b * b + c * c + 2.0f * off) / 6.0f);
  if (!(p > 0.0f)) return {mean, mean, mean};
  const float half_determinant =
      0.5f * (a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz));
  const float r = std::clamp(half_determinant / (p * p * p), -1.0f, 1.0f);
  // With angle = acos|r| / 3 in [0, pi / 6] they lie at 2 p cos(angle + 2 n pi / 3), or mirrored.
  const auto [cosine, sine] = third_of_arc_cosine(std::abs(r));
  const float far = 2.0f * p * cosine;
  const float near = p * (cosine - std::numbers::sqrt3_v<float> * sine);
  if (r < 0.0f) return {mean - far, mean + near, mean + far - near};
  return {mean - far + near, mean - near, mean + far};
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
