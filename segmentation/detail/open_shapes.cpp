#include "segmentation/detail/open_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <queue>
#include <utility>

#include "core/units.hpp"

namespace angio::segmentation::detail {
namespace {

/// On the border, or by how often a ray to the right crosses it.
bool is_within(const std::vector<double>& corners, double column, double row) {
  constexpr double kOn = 1e-6;  // pixels
  bool inside = false;
  const std::size_t count = corners.size() / 2;
  for (std::size_t a = 0, b = count - 1; a < count; b = a++) {
    const double ax = corners[2 * a], ay = corners[2 * a + 1], bx = corners[2 * b],
                 by = corners[2 * b + 1];
    const double x = bx - ax, y = by - ay, length = x * x + y * y;
    const double part =
        length > 0.0 ? std::clamp(((column - ax) * x + (row - ay) * y) / length, 0.0, 1.0) : 0.0;
    if (std::hypot(ax + part * x - column, ay + part * y - row) <= kOn) return true;
    if ((ay > row) != (by > row) && column < ax + (row - ay) / (by - ay) * (bx - ax))
      inside = !inside;
  }
  return inside;
}

/// Covered pixels take the value of the pixel that reaches them on the shortest way, as the crow
/// flies.
void spread(std::vector<int>& from, int columns, int rows) {
  using Entry = std::pair<float, std::pair<int, int>>;  // distance, pixel, source
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto reach_neighbours = [&](int pixel, int source) {
    const int c = pixel % columns, r = pixel / columns;
    for (int y = std::max(0, r - 1); y <= std::min(rows - 1, r + 1); ++y)
      for (int x = std::max(0, c - 1); x <= std::min(columns - 1, c + 1); ++x)
        if (from[std::size_t(y) * std::size_t(columns) + std::size_t(x)] < 0)
          queue.emplace(std::hypot(float(source % columns - x), float(source / columns - y)),
                        std::pair{y * columns + x, source});
  };
  for (int pixel = 0; pixel < columns * rows; ++pixel)
    if (from[std::size_t(pixel)] >= 0) reach_neighbours(pixel, pixel);
  while (!queue.empty()) {
    const auto [pixel, source] = queue.top().second;
    queue.pop();
    if (from[std::size_t(pixel)] >= 0) continue;
    from[std::size_t(pixel)] = source;
    reach_neighbours(pixel, source);
  }
}

}  // namespace

std::vector<double> circle_corners(double column, double row, double radius) {
  constexpr int kCorners = 96;  // of which four reach the farthest columns and rows
  const double outer = radius / std::cos(units::kPi / kCorners);
  std::vector<double> corners;
  for (int n = 0; n < kCorners; ++n) {
    const double angle = 2.0 * units::kPi * n / kCorners;
    corners.push_back(column + outer * std::cos(angle));
    corners.push_back(row + outer * std::sin(angle));
  }
  return corners;
}

std::vector<int> open_pixels(const std::vector<std::vector<double>>& shapes, int columns,
                             int rows) {
  std::vector<int> from(std::size_t(columns) * std::size_t(rows), -1);
  std::size_t open = 0;
  for (int row = 0; row < rows; ++row)
    for (int c = 0; c < columns; ++c) {
      const auto holds = [&](const std::vector<double>& corners) {
        return is_within(corners, c + 1.0, row + 1.0);
      };
      if (!std::all_of(shapes.begin(), shapes.end(), holds)) continue;
      from[std::size_t(row) * std::size_t(columns) + std::size_t(c)] = row * columns + c;
      ++open;
    }
  if (open == 0 || open == from.size()) return {};
  spread(from, columns, rows);
  return from;
}

}  // namespace angio::segmentation::detail
