#pragma once

#include <cstdint>
#include <vector>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// A mask in parts that hang together by necks.
struct Bodies {
  /// Where two bodies touch.
  struct Neck {
    std::int32_t one, other;
    float depth_mm;  ///< of the deepest way from one to the other
  };
  std::vector<std::int32_t> label;  ///< 0 outside, else 1, 2, ..., shape [voxel_count]
  std::vector<float> depth_mm;      ///< of the deepest voxel, shape [body_count + 1]; [0] is unused
  std::vector<Neck> necks;          ///< deepest first
  [[nodiscard]] int count() const { return int(depth_mm.size()) - 1; }
};

/// Floods a mask from its deepest voxels on (Vincent and Soille, IEEE PAMI 13(6), 1991). Each
/// deepest place is a body of its own, but two of them that are at least `least_depth_mm` deep are
/// one if the way between them is as deep as `neck_share` of the less deep.
///
/// @param depth  of the mask (depth_in)
Bodies part_into_bodies(const Volume<float>& depth, double least_depth_mm, double neck_share);

enum class Tissue : std::uint8_t { unknown, blood, other };

/// Gives each body of unknown tissue that of the one that it hangs on by the deepest necks; it
/// stays unknown where there is none.
/// @param tissues  shape [body_count + 1]
void spread(const Bodies& bodies, std::vector<Tissue>& tissues);

}  // namespace angio::segmentation::detail
