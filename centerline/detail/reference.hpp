#pragma once

#include <vector>

#include "centerline/detail/branches.hpp"
#include "centerline/detail/healthy_field.hpp"
#include "core/centerline.hpp"

namespace angio::centerline {

/// The diameter that a path would have without disease. All arrays have shape [point].
struct ReferenceDiameter {
  std::vector<double> diameter;  ///< [mm]
  std::vector<double> measured;  ///< the lumen's diameter [mm]; 0 where a branching hides it
  std::vector<char> healthy;     ///< 1: measured, and as wide as the reference within its scatter
  std::vector<int> branch;       ///< index into TreeReference::branches
  std::vector<int> cell;         ///< of the branch in the field; -1 where nothing is measured
};

struct TreeReference {
  std::vector<Branch> branches;
  std::vector<FieldBranch> field_branches;  ///< shape [branch]
  HealthyField field;
  std::vector<ReferenceDiameter> paths;  ///< shape [path]
};

/// Reference diameters of a whole tree.
///
/// The diameters of each branch, cut into cells of a quarter of a diameter, go into a HealthyField,
/// which finds the healthy tree that explains most of them. Through the cells that agree with it
/// runs, on each branch, a local straight line in ln(diameter) (robust local regression: Cleveland,
/// J. Am. Stat. Assoc. 74(368), 1979, doi:10.1080/01621459.1979.10481038), which is the reference.
/// Where no cell agrees, it is the field's own value. Nothing is told by a thread in which a line
/// ends, under a third as wide as the branch, nor by a throat that is a third narrower than both of
/// its sides.
///
/// Where nothing is measured in the whole tree (a piece of vessel hardly longer than its fork), the
/// reference of a path is the median of its balls' diameters.
///
/// Lengths count in diameters of the vessel around, so nothing changes when a tree is scaled. What
/// tracts with `blanking` hide is not measured.
///
/// @param voxel_mm  edge of the voxels that the lumen was seen in; diameters err by 1 / sqrt(12) of
///                  it, as lengths do that are counted in whole voxels. 0: they are exact
TreeReference find_reference(const CenterlineTree& tree, double voxel_mm);

}  // namespace angio::centerline
