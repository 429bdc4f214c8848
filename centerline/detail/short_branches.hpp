#pragma once

#include <optional>
#include <vector>

#include "centerline/detail/lumen_voxels.hpp"

/// What a short branch is: a bump of the wall, the sac of an aneurysm, or a vessel that was cut off
/// close to a fork.
namespace angio::centerline {

/// The paths to the ends that were found so far, which part once and never meet again.
class VoxelTree {
 public:
  explicit VoxelTree(int voxel_count)
      : toward_root_(std::size_t(voxel_count), kOutside),
        first_away_(std::size_t(voxel_count), kOutside),
        next_beside_(std::size_t(voxel_count), kOutside) {}

  [[nodiscard]] bool has(int voxel) const { return toward_root_[std::size_t(voxel)] != kOutside; }
  /// Adds a branch.
  /// @param own       its voxels, tip first
  /// @param junction  the tree's voxel that it leaves; -1: it is the first
  void add(const std::vector<int>& own, int junction);
  /// The tree's arms at one of its voxels: the ways from there, up to a length [mm]; where one
  /// parts, the way that was added first.
  [[nodiscard]] std::vector<std::vector<int>> arms(const LumenVoxels& lumen, int voxel,
                                                   double length) const;

 private:
  static constexpr int kNone = -1, kOutside = -2;
  std::vector<int> toward_root_;               ///< kNone: the root
  std::vector<int> first_away_, next_beside_;  ///< the voxels that come from one, as a list
};

/// Whether the border of the volume cuts a voxel's surroundings off.
bool at_border(const LumenVoxels& lumen, int voxel);

/// Whether a branch is the sac of an aneurysm: wider inside than at its mouth, and beyond its
/// parent's wall not longer than 1.5 times its width, or 2.5 times where it is wider than its
/// parent: vessels do not widen as they branch. Where other vessels are cut off flat, one that is
/// round and wider than its parent needs no narrower mouth. One that the border of the volume cuts
/// off is a vessel.
/// @param own  the branch's voxels, tip first
/// @param junction  the parent's voxel that it leaves
bool is_sac(const LumenVoxels& lumen, const std::vector<int>& own, int junction,
            bool others_are_cut);

/// The end of a branch that is, however short, the stump of a vessel that was cut off behind a
/// fork: it goes on (within 65 degrees) where another arm of the fork comes from, a ball as wide as
/// that arm (within a quarter) fits into it with its middle outside the fork's own ball, and the
/// fork's other arms are too thin (0.6) to take that arm's blood. A sac sits on a vessel that goes
/// on as wide.
/// @param own  the branch's voxels, tip first
/// @param junction  the tree's voxel that it leaves
/// @return the middle of its end [mm]; nothing: it is no stump
std::optional<Vec3> end_of_stump(const LumenVoxels& lumen, const VoxelTree& tree,
                                 const std::vector<int>& own, int junction);

/// The radius [mm] of a branch that leaves a wider one (by a third), if it is a tube: from its tip
/// on it is longer by half than wide before it reaches its parent's ball, and than four voxels.
/// Bumps and corners, which widen towards the parent as fast as they come nearer, are not; a
/// vessel's mouth may widen.
/// @param own  the branch's voxels, tip first
/// @param junction  the tree's voxel that it leaves
/// @param prominence  from the flow divider to its tip [mm]; that much longer, too
std::optional<double> radius_of_tube(const LumenVoxels& lumen, const std::vector<int>& own,
                                     int junction, double prominence);

}  // namespace angio::centerline
