#include "segmentation/detail/evenness.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/parallel.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kReach = 0.8;          ///< [mm] and [voxels], the longer of the two
constexpr double kDepthReaches = 2.75;  ///< there an edge adds 0.05 of its height to the deviation
constexpr float kEvenShare = 1.6f;      ///< of the deviation in tissue
constexpr float kClippedShare = 0.3f;  ///< and no less: values cut at the scale's end have no noise
constexpr double kNoiseBlock = 8.0;    ///< [mm] of the grid on which noise is looked at
constexpr double kNoiseReach = 20.0;   ///< [mm] standard deviation of what is around
constexpr double kQuiet = 0.2;         ///< of a block's tissue is the quietest, whose deviation is
constexpr float kQuietNoise = 0.9f;    ///< times that of noise: it is measured to some 15 %
constexpr float kLeastNoise = 1.0f, kMostNoise = 1.75f;  ///< of the whole volume's
constexpr float kAboveTissue = 0.25f;                    ///< contrasts above the level of tissue,
constexpr float kBelowTissue = 1.5f;                     ///< and below it: fat, muscle and organs
constexpr float kRange = 5.0f;  ///< contrasts beyond tissue: values farther away are cut
constexpr std::size_t kBinCount = 400;

bool is_tissue(float mean, const BloodLevel& level) {
  const float above = mean - level.tissue;
  return above <= kAboveTissue * level.contrast() && above >= -kBelowTissue * level.contrast();
}

/// The commonest deviation, to a bin's width, of the voxels whose mean is that of soft tissue.
float commonest(const Volume<float>& mean, const Volume<float>& deviation,
                const BloodLevel& level) {
  const float bin = 0.5f * level.contrast() / float(kBinCount);
  std::vector<double> count(kBinCount, 0.0);
  for (std::size_t v = 0; v < mean.values.size(); ++v) {
    if (!is_tissue(mean.values[v], level)) continue;
    const auto b = std::size_t(deviation.values[v] / bin);
    if (b < kBinCount) count[b] += 1.0;
  }
  const auto around = [&](std::size_t b) {
    return count[b - 2] + count[b - 1] + count[b] + count[b + 1] + count[b + 2];
  };
  std::size_t best = 2;
  for (std::size_t b = 2; b + 2 < kBinCount; ++b)
    if (around(b) > around(best)) best = b;
  return bin * (float(best) + 0.5f);
}

/// The noise around each place, on a coarse grid.
///
/// @param of_tissue  the whole volume's, where there is no tissue near
CoarseField noise_around(const Volume<float>& mean, const Volume<float>& deviation,
                         const BloodLevel& level, float of_tissue) {
  constexpr std::size_t kLeastVoxels = 20;
  constexpr float kLeastWeight = 0.02f;
  const auto factor = block_size(mean.geometry, kNoiseBlock);
  const auto& size = mean.geometry.size;
  VolumeGeometry blocks = mean.geometry;
  for (std::size_t a = 0; a < 3; ++a) {
    blocks.size[a] = (size[a] + factor[a] - 1) / factor[a];
    blocks.spacing[int(a)] *= factor[a];
  }
  Volume<float> weight(blocks), noise(blocks);
  parallel_for(blocks.size[2], [&](std::ptrdiff_t k) {
    std::vector<float> of_block;
    for (int j = 0; j < blocks.size[1]; ++j)
      for (int i = 0; i < blocks.size[0]; ++i) {
        of_block.clear();
        for (int kk = int(k) * factor[2]; kk < std::min(size[2], (int(k) + 1) * factor[2]); ++kk)
          for (int jj = j * factor[1]; jj < std::min(size[1], (j + 1) * factor[1]); ++jj)
            for (int ii = i * factor[0]; ii < std::min(size[0], (i + 1) * factor[0]); ++ii)
              if (is_tissue(mean.at(ii, jj, kk), level))
                of_block.push_back(deviation.at(ii, jj, kk));
        if (of_block.size() < kLeastVoxels) continue;
        const auto quiet = of_block.begin() + std::ptrdiff_t(kQuiet * double(of_block.size()));
        std::nth_element(of_block.begin(), quiet, of_block.end());
        weight.at(i, j, int(k)) = 1.0f;
        noise.at(i, j, int(k)) = *quiet / kQuietNoise;
      }
  });
  weight = smooth(weight, kNoiseReach);
  noise = smooth(noise, kNoiseReach);
  for (std::size_t b = 0; b < noise.values.size(); ++b) {
    const float w = weight.values[b];
    noise.values[b] = std::clamp((noise.values[b] + kLeastWeight * of_tissue) / (w + kLeastWeight),
                                 kLeastNoise * of_tissue, kMostNoise * of_tissue);
  }
  return {std::move(noise), factor};
}

}  // namespace

bool Evenness::is_even(std::size_t v) const {
  return unevenness.values[v] > kClippedShare && unevenness.values[v] < kEvenShare;
}

double Evenness::depth_mm() const { return kDepthReaches * reach_mm; }

Evenness find_evenness(const Volume<float>& volume, const BloodLevel& level) {
  Evenness evenness;
  evenness.reach_mm = kReach * std::max(1.0, mean_spacing(volume.geometry));
  // Counted from tissue, so that the difference of squares keeps its digits.
  Volume<float> value(volume.geometry), square(volume.geometry);
  const float range = kRange * level.contrast();
  parallel_for(volume.geometry.size[2], [&](std::ptrdiff_t k) {
    const std::size_t slice = value.values.size() / std::size_t(volume.geometry.size[2]);
    for (std::size_t v = std::size_t(k) * slice; v < (std::size_t(k) + 1) * slice; ++v) {
      const float from_tissue = std::clamp(volume.values[v] - level.tissue, -range, range);
      value.values[v] = from_tissue;
      square.values[v] = from_tissue * from_tissue;
    }
  });
  evenness.mean = smooth(value, evenness.reach_mm);
  Volume<float> deviation = smooth(square, evenness.reach_mm);
  parallel_for(volume.geometry.size[2], [&](std::ptrdiff_t k) {
    const std::size_t slice = value.values.size() / std::size_t(volume.geometry.size[2]);
    for (std::size_t v = std::size_t(k) * slice; v < (std::size_t(k) + 1) * slice; ++v) {
      float& mean = evenness.mean.values[v];
      deviation.values[v] = std::sqrt(std::max(0.0f, deviation.values[v] - mean * mean));
      mean += level.tissue;
    }
  });
  evenness.of_tissue = commonest(evenness.mean, deviation, level);
  const CoarseField noise = noise_around(evenness.mean, deviation, level, evenness.of_tissue);
  parallel_for(volume.geometry.size[2], [&](std::ptrdiff_t k) {
    std::vector<float> around(static_cast<std::size_t>(volume.geometry.size[0]));
    for (int j = 0; j < volume.geometry.size[1]; ++j) {
      noise.row(j, int(k), volume.geometry.size[0], around.data());
      float* row = &deviation.at(0, j, int(k));
      for (std::size_t i = 0; i < around.size(); ++i) row[i] /= around[i];
    }
  });
  evenness.unevenness = std::move(deviation);
  return evenness;
}

}  // namespace angio::segmentation::detail
