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

constexpr double kBlocksPerSigma = 2.5;         ///< coarse voxels per standard deviation
constexpr double kLeastSigmaVoxels = 0.9;       ///< below it, differences stand for no derivative
constexpr double kBorderSigmas = 2.5;           ///< from the volume's border
constexpr float kBorderNoise = 1.6f;            ///< more noise there, for each axis
constexpr float kLeastShare = 0.1f;             ///< of blood's contrast that a tube of it must have
constexpr float kMostShare = 0.4f;              ///< of it that is asked for because of tissue,
constexpr float kMostAmongOrgans = 0.6f;        ///< and among organs, if tissue has no more
constexpr float kTissueExcess = 1.3f;           ///< of the contrast that tissue would have there
constexpr float kLeastLevel = 0.25f;            ///< of the way from tissue to blood
constexpr double kFullLevelRadiusVoxels = 2.2;  ///< of a tube that shows its full level
constexpr double kMadToDeviation = 1.4826;      ///< of a normal distribution

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
CoarseField contrast_at_scale(const ScaleView& view, double sigma) {
  Volume<float> l2 = middle_eigenvalue(view.smoothed);
  const double scale = std::numbers::e * sigma * sigma;
  const auto noise = float(kNoiseDeviations * robust_deviation(l2.values));
  const auto& size = l2.geometry.size;
  // Beyond the border its voxels are repeated, so that less noise is averaged out there.
  const auto border_factor = [&](int index, int axis) {
    const double from_border =
        std::min(index, size[std::size_t(axis)] - 1 - index) * l2.geometry.spacing[axis];
    return from_border < kBorderSigmas * sigma ? kBorderNoise : 1.0f;
  };
  parallel_for(size[2], [&](std::ptrdiff_t k) {
    const float slice_noise = noise * border_factor(int(k), 2);
    for (int j = 0; j < size[1]; ++j) {
      const float row_noise = slice_noise * border_factor(j, 1);
      for (int i = 0; i < size[0]; ++i) {
        float& value = l2.at(i, j, int(k));
        value = -value > row_noise * border_factor(i, 0) ? float(scale) * -value : 0.0f;
      }
    }
  });
  return {std::move(l2), view.factor};
}

/// What a tube's contrast must be to hold blood, by the level of its surroundings.
float least_contrast(const BloodLevel& level, float surroundings) {
  const float blood = level.lumen - surroundings;
  const float excess = kTissueExcess * (level.tissue - surroundings);
  const bool is_told = level.is_even && excess < kMostAmongOrgans * blood;
  const float most = is_told ? kMostAmongOrgans : kMostShare;
  return std::clamp(excess, kLeastShare * blood, most * blood);
}

/// C without the tubes that hold no blood; a mask of those that do is left in `blood`.
Volume<float> contrast_of_blood(const ScaleView& view, const Volume<float>& contrast, double sigma,
                                const BloodLevel& level, Volume<std::uint8_t>& blood) {
  // A Gaussian of twice the scale holds 22 % of a tube of the scale's radius, the scale's own 63 %.
  constexpr float kHeldWide = 0.22f, kLost = 0.37f;
  const Volume<float> wide = smooth(view.smoothed, std::sqrt(3.0) * sigma);
  const bool is_resolved =
      std::numbers::sqrt2 * sigma >= kFullLevelRadiusVoxels * mean_spacing(view.voxels);
  const float quarter = level.tissue + kLeastLevel * level.contrast();
  const float least_level = level.is_even ? level.half() : quarter;
  Volume<float> kept = contrast;
  blood = Volume<std::uint8_t>(contrast.geometry, 0);
  for (std::size_t v = 0; v < kept.values.size(); ++v) {
    float& c = kept.values[v];
    if (c <= 0.0f) continue;
    const float around = wide.values[v] - kHeldWide * c;
    const float surroundings = std::min(around, level.tissue);
    // Beside tissue alone a low level is that of a narrow place, or of a thinner tube.
    const bool is_in_dark = surroundings < level.tissue - kLeastLevel * level.contrast();
    const bool is_in_organ = level.is_even && around > quarter;
    const bool shows_level = is_in_organ || (is_resolved && is_in_dark);
    const bool is_blood = c >= least_contrast(level, surroundings) &&
                          (!shows_level || view.smoothed.values[v] + kLost * c > least_level);
    blood.values[v] = is_blood;
    if (!is_blood) c = 0.0f;
  }
  return kept;
}

/// Marks the boxes around the set voxels.
void widen(Volume<std::uint8_t>& mask, double reach_mm) {
  const auto& size = mask.geometry.size;
  const std::array<std::size_t, 3> stride{1, std::size_t(size[0]),
                                          std::size_t(size[0]) * std::size_t(size[1])};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int steps = int(std::lround(reach_mm / mask.geometry.spacing[int(axis)]));
    const std::size_t a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
    parallel_for(size[b], [&](std::ptrdiff_t row) {
      std::vector<std::uint8_t> line(static_cast<std::size_t>(size[axis]));
      for (int n = 0; n < size[a]; ++n) {
        std::uint8_t* at =
            mask.values.data() + std::size_t(row) * stride[b] + std::size_t(n) * stride[a];
        int last = -steps - 1, next = 0;
        for (int i = 0; i < size[axis]; ++i) {
          for (; next < size[axis] && next <= i + steps; ++next)
            if (at[std::size_t(next) * stride[axis]]) last = next;
          line[std::size_t(i)] = last >= i - steps;
        }
        for (int i = 0; i < size[axis]; ++i)
          at[std::size_t(i) * stride[axis]] = line[std::size_t(i)];
      }
    });
  }
}

/// Takes the highest C of all scales, and the places near any tube.
void join_scale(const CoarseField& contrast, const Volume<std::uint8_t>& near,
                const std::array<int, 3>& factor, Tubes& tubes) {
  parallel_for(tubes.contrast.geometry.size[2], [&](std::ptrdiff_t k) {
    const auto& size = tubes.contrast.geometry.size;
    std::vector<float> row(static_cast<std::size_t>(size[0]));
    for (int j = 0; j < size[1]; ++j) {
      contrast.row(j, int(k), size[0], row.data());
      float* out = &tubes.contrast.at(0, j, int(k));
      for (std::size_t i = 0; i < row.size(); ++i) out[i] = std::max(out[i], row[i]);
      if (near.values.empty()) continue;
      const std::uint8_t* from = &near.at(0, j / factor[1], int(k) / factor[2]);
      std::uint8_t* to = &tubes.is_near.at(0, j, int(k));
      for (int i = 0; i < size[0]; ++i) to[i] |= from[i / factor[0]];
    }
  });
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
  Vec3 left;
  for (int axis = 0; axis < 3; ++axis) {
    const double h = blocks.geometry.spacing[axis], voxel = volume.geometry.spacing[axis];
    // A block average blurs by h^2 / 12 beyond what a voxel holds already, a difference by h^2 / 6.
    const double blurred = (h * h - voxel * voxel) / 12.0 + h * h / 6.0;
    left[axis] = std::sqrt(std::max(sigma * sigma - blurred, 0.0));
  }
  return {smooth(blocks, left), factor, volume.geometry};
}

Tubes find_tubes(const Volume<float>& volume, const std::vector<double>& radii_mm,
                 const BloodLevel& level, const Progress& progress) {
  const double voxel = mean_spacing(volume.geometry);
  Tubes tubes{Volume<float>(volume.geometry, 0.0f), Volume<std::uint8_t>(volume.geometry, 0),
              Volume<std::uint8_t>(volume.geometry, level.is_told ? 0 : 1)};
  for (std::size_t s = 0; s < radii_mm.size(); ++s) {
    const double sigma = std::max(radii_mm[s] / std::numbers::sqrt2, kLeastSigmaVoxels * voxel);
    const ScaleView view = view_at_scale(volume, sigma);
    CoarseField contrast = contrast_at_scale(view, sigma);
    Volume<std::uint8_t> near;
    if (level.is_told) {
      contrast = {contrast_of_blood(view, contrast.coarse(), sigma, level, near), view.factor};
      widen(near, std::numbers::sqrt2 * sigma + voxel);
    }
    join_scale(contrast, near, view.factor, tubes);
    if (s == 0)
      for (std::size_t v = 0; v < tubes.is_thin.values.size(); ++v)
        tubes.is_thin.values[v] = tubes.contrast.values[v] > 0.0f;
    progress.report(0.1 + 0.2 * double(s + 1) / double(radii_mm.size()), "enhancing vessels");
  }
  return tubes;
}

Volume<float> tube_contrast(const Volume<float>& volume, const std::vector<double>& radii_mm,
                            const Progress& progress) {
  return find_tubes(volume, radii_mm, {}, progress).contrast;
}

}  // namespace angio::segmentation::detail
