#include "core/require.hpp"

#include <cstdio>

#include "core/error.hpp"

namespace angio {

std::string range_fault(std::string_view field, double value, double low, double high) {
  if (value >= low && value <= high) return {};  // no number is within
  char text[120];
  std::snprintf(text, sizeof text, " is %.8g (it must lie in [%.8g, %.8g])", value, low, high);
  return std::string(field) + text;
}

void require_within(std::string_view field, double value, double low, double high,
                    std::string_view advice) {
  const std::string fault = range_fault(field, value, low, high);
  if (!fault.empty()) throw OptionError(fault + std::string(advice));
}

void require(bool good, std::string_view field, std::string_view allowed) {
  if (!good)
    throw OptionError(std::string(field) + " is out of range (allowed: " + std::string(allowed) +
                      ")");
}

}  // namespace angio
