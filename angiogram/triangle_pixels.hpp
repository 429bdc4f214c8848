#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

/// A triangle in a picture: which rays meet it, each of a closed surface's as often in as out.
namespace angio::angiogram::detail {

/// A corner as the detector has it: right and up in pixels, from the middle of the picture's lower
/// left pixel; depth grows towards the detector, or falls
/// as its reciprocal (add_triangle).
struct Corner {
  double x = 0.0, y = 0.0, depth = 0.0;
  int vertex = 0;
};

/// Twice the area of a, b and the place; the same number, but for its sign, from both sides of an
/// edge.
inline double side(const Corner& a, const Corner& b, double x, double y) {
  const bool is_turned = a.vertex > b.vertex;
  const Corner& from = is_turned ? b : a;
  const Corner& to = is_turned ? a : b;
  const double value = (to.x - from.x) * (y - from.y) - (to.y - from.y) * (x - from.x);
  return is_turned ? -value : value;
}

/// Whether the place, moved by (e, e^2), lies left of the edge.
inline bool is_left(const Corner& a, const Corner& b, double value) {
  if (value != 0.0) return value > 0.0;
  if (a.y != b.y) return b.y < a.y;
  return b.x > a.x;
}

/// Adds a triangle's +- depth to the pixels whose rays meet it.
/// @param depth_of  the depth from what the corners carry, which is linear in the picture
template <class DepthOf>
void add_triangle(const std::array<Corner, 3>& corners, int columns, int rows,
                  const DepthOf& depth_of, std::vector<double>& chords) {
  const auto [a, b, c] = corners;
  const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (area == 0.0) return;  // seen edge on
  const auto first = [](double low) { return int(std::max(0.0, std::ceil(low))); };
  const auto last = [](double high, int count) {
    return int(std::min(count - 1.0, std::floor(high)));
  };
  const int x0 = first(std::min({a.x, b.x, c.x})), x1 = last(std::max({a.x, b.x, c.x}), columns);
  const int y0 = first(std::min({a.y, b.y, c.y})), y1 = last(std::max({a.y, b.y, c.y}), rows);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double ab = side(a, b, x, y), bc = side(b, c, x, y), ca = side(c, a, x, y);
      const bool left = is_left(a, b, ab);
      if (is_left(b, c, bc) != left || is_left(c, a, ca) != left) continue;
      const double depth = depth_of((bc * a.depth + ca * b.depth + ab * c.depth) / area);
      const auto row = std::size_t(rows - 1 - y);
      // Counter-clockwise for the detector: here the ray leaves.
      chords[row * std::size_t(columns) + std::size_t(x)] += left ? depth : -depth;
    }
}

}  // namespace angio::angiogram::detail
