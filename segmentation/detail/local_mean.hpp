#pragma once

#include <utility>

#include "core/parallel.hpp"
#include "core/volume.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {

/// A mean of value(v) over the voxels where weight(v) > 0, told everywhere: near such voxels their
/// local mean, far from them a wider one, by normalised convolution on a grid of 1 mm.
///
/// @param everywhere  the value farther than all kernels reach
template <class Value, class Weight>
CoarseField local_mean(const VolumeGeometry& geometry, float everywhere, const Value& value,
                       const Weight& weight) {
  constexpr double kFieldSpacing = 1.0;                    // [mm]
  constexpr double kFieldReach[] = {16.0, 8.0, 4.0, 2.0};  // [mm] kernels, widest first
  constexpr float kPriorWeight = 0.02f;  // of the wider kernel against a full narrow one
  Volume<float> weights(geometry);
  Volume<float> sums(geometry);
  parallel_for(geometry.size[2], [&](std::ptrdiff_t k) {
    const std::size_t slice = weights.values.size() / std::size_t(geometry.size[2]);
    for (std::size_t v = std::size_t(k) * slice; v < (std::size_t(k) + 1) * slice; ++v) {
      weights.values[v] = weight(v);
      sums.values[v] = weights.values[v] > 0.0f ? weights.values[v] * value(v) : 0.0f;
    }
  });
  const auto factor = block_size(geometry, kFieldSpacing);
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

}  // namespace angio::segmentation::detail
