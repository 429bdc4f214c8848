#pragma once

#include "centerline/detail/dip.hpp"

/// Narrowings that are seen, but may be no stenoses.
namespace angio::centerline {

/// Where a narrowing lies.
struct LesionSurroundings {
  bool is_crowded = false;  ///< the tree is large, or its vessels touch or form loops
  bool is_scan = false;     ///< the lines end where an image does
};

/// Is the tree's reference more than 1.5 times as wide as the healthy vessel on both sides, as
/// where a trunk gives way to a branch that is thin by itself?
bool is_wider_than_beside(const Lesion& lesion);

/// Why a dip is in doubt by what lies around it: the first reason that holds, or none.
Doubt find_doubt(const Known& known, const Vessel& vessel, const Dip& dip, const Lesion& lesion,
                 const LesionSurroundings& around);

}  // namespace angio::centerline
