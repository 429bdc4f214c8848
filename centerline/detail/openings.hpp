#pragma once

#include <vector>

#include "core/vec3.hpp"

namespace angio::centerline {

/// Where a surface's vessel was cut off.
struct OpenRim {
  Vec3 middle;          ///< LPS [mm]
  double radius = 0.0;  ///< of the circle of its area [mm]
};

/// What a surface tells of its ends.
struct Openings {
  std::vector<OpenRim> rims;
  bool are_caps = false;           ///< the surface was closed, and the rims are its flat caps
  std::vector<OpenRim> flat_ends;  ///< flat ends with rounded edges
};

}  // namespace angio::centerline
