#pragma once

#include <optional>
#include <string>
#include <vector>

#include "centerline/centerline.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/openings.hpp"
#include "core/progress.hpp"

namespace angio::centerline {

/// The lumen's voxel paths from the inlet to each outlet.
struct Skeleton {
  struct Chain {
    std::vector<int> voxels;   ///< inlet first; chains share their first voxels until they part
    bool ends_at_cut = false;  ///< the far end is where a loop was cut, not a wall
    std::optional<Vec3> rim;   ///< middle of the open rim, cap or stump where it ends [mm]
  };
  std::vector<Chain> chains;      ///< the longest first
  std::optional<Vec3> inlet_rim;  ///< the same of the inlet [mm]
  bool starts_at_end = true;      ///< false: the inlet was put inside a vessel
  std::vector<std::string> warnings;
};

/// Finds inlet and outlets (where the options do not give them) and the paths between, along the
/// middle of the lumen. Cuts loops in `lumen`.
/// @param openings  with two or more rims, every rim is an end; of an open surface blood comes in
///                  by one of them, and what ends without a rim is an outlet only if it is a vessel
///                  (three times as long as wide), and told; of a capped one, if it is longer than
///                  wide. A flat end is one, however short its vessel
/// @throws InputError  when nothing tubular is in it
Skeleton find_skeleton(LumenVoxels& lumen, const CenterlineOptions& options,
                       const Openings& openings, const Progress& progress);

/// How far from the tip of a chain the tip's own shape (a flat cap, a dome) is felt: the longest
/// arc a with depth(a) < a / 2. Along the edge of a flat cap the depth grows by 0.7 a, into a dome
/// by a, along a tapering vessel by much less.
/// @param points, depth  of the chain, tip first
/// @return index of the first point that is free of it
int end_of_cap(const std::vector<Vec3>& points, const std::vector<double>& depth);

}  // namespace angio::centerline
