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
constexpr float kEvenShare = 1.6f;  ///< of the deviation in tissue: noise is not the same all over
constexpr float kAboveTissue = 0.25f;  ///< contrasts above the level of tissue,
constexpr float kBelowTissue = 1.5f;   ///< and below it: fat, muscle and organs
constexpr float kRange = 5.0f;         ///< contrasts beyond tissue: values farther away are cut
constexpr std::size_t kBinCount = 400;

/// The commonest deviation, to a bin's width, of the voxels whose mean is that of soft tissue.
float commonest(const Evenness& evenness, const BloodLevel& level) {
  const float bin = 0.5f * level.contrast() / float(kBinCount);
  std::vector<double> count(kBinCount, 0.0);
  for (std::size_t v = 0; v < evenness.mean.values.size(); ++v) {
    const float above = evenness.mean.values[v] - level.tissue;
    if (above > kAboveTissue * level.contrast() || above < -kBelowTissue * level.contrast())
      continue;
    const auto b = std::size_t(evenness.deviation.values[v] / bin);
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

}  // namespace

bool Evenness::is_even(std::size_t v) const { return deviation.values[v] < kEvenShare * of_tissue; }

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
  evenness.deviation = smooth(square, evenness.reach_mm);
  parallel_for(volume.geometry.size[2], [&](std::ptrdiff_t k) {
    const std::size_t slice = value.values.size() / std::size_t(volume.geometry.size[2]);
    for (std::size_t v = std::size_t(k) * slice; v < (std::size_t(k) + 1) * slice; ++v) {
      float& mean = evenness.mean.values[v];
      float& deviation = evenness.deviation.values[v];
      deviation = std::sqrt(std::max(0.0f, deviation - mean * mean));
      mean += level.tissue;
    }
  });
  evenness.of_tissue = commonest(evenness, level);
  return evenness;
}

}  // namespace angio::segmentation::detail
