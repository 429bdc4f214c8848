#pragma once

#include <cmath>
#include <cstdio>
#include <string>

#include "core/vec3.hpp"

namespace angio::segmentation::detail {

/// A number for people: up to four significant digits.
inline std::string format_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

/// A place in LPS [mm] for people: "(x, y, z) mm", to tenths.
inline std::string format_place(const Vec3& place) {
  const auto tenths = [](double mm) {
    return format_number(0.1 * std::round(10.0 * mm) + 0.0);  // -0 is 0
  };
  return "(" + tenths(place.x) + ", " + tenths(place.y) + ", " + tenths(place.z) + ") mm";
}

}  // namespace angio::segmentation::detail
