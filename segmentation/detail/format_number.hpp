#pragma once

#include <cstdio>
#include <string>

namespace angio::segmentation::detail {

/// A number for people: up to four significant digits.
inline std::string format_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace angio::segmentation::detail
