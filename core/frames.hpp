#pragma once

#include "core/vec3.hpp"

/// Coordinate frames. Every point of the program is in DICOM's patient frame LPS [mm]: x to the
/// patient's left, y to the back, z to the head. NIfTI's frame is RAS.
namespace angio {

/// LPS and RAS differ in the sign of x and y, so this is also its own inverse.
constexpr Vec3 lps_from_ras(const Vec3& point_in_ras) {
  return {-point_in_ras.x, -point_in_ras.y, point_in_ras.z};
}

}  // namespace angio
