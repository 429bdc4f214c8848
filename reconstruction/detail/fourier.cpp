#include "reconstruction/detail/fourier.hpp"

#include <cmath>

#include "core/units.hpp"

namespace angio::reconstruction::detail {

std::vector<Complex> fourier_roots(int length) {
  std::vector<Complex> roots;
  for (int j = 0; j < 3 * length / 4; ++j) {
    const double angle = -2.0 * units::kPi * j / length;
    roots.push_back({float(std::cos(angle)), float(std::sin(angle))});
  }
  return roots;
}

int frequency_at(int place, int length) {
  int frequency = 0, factor = 1;
  for (int span = length; span > 1;) {
    const int radix = span >= 4 ? 4 : 2;
    span /= radix;
    frequency += factor * (place / span);
    place %= span;
    factor *= radix;
  }
  return frequency;
}

int fourier_length(int least) {
  int length = 4;
  while (length < least) length *= 2;
  return length;
}

}  // namespace angio::reconstruction::detail
