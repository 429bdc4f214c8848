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

constexpr double kOn = 1e-6;  ///< so near to a border a pixel lies on it [pixels]

/// Covers the pixels of a row that lie outside a polygon: its edges cross the row at places between
/// which, two by two, it is inside; what touches the row is border.
void cover_outside(const std::vector<double>& corners, int row, std::vector<char>& is_open) {
  const double y = row + 1.0;
  std::vector<char> inside(is_open.size(), 0);
  const auto fill = [&](double from, double to) {
    const int first = int(std::clamp(std::ceil(from - kOn), 1.0, double(inside.size()) + 1.0)),
              last = int(std::clamp(std::floor(to + kOn), 0.0, double(inside.size())));
    for (int column = first; column <= last; ++column) inside[std::size_t(column) - 1] = 1;
  };
  std::vector<double> crossings;
  const std::size_t count = corners.size() / 2;
  for (std::size_t a = 0, b = count - 1; a < count; b = a++) {
    const double ax = corners[2 * a], ay = corners[2 * a + 1], bx = corners[2 * b],
                 by = corners[2 * b + 1];
    if (std::min(ay, by) > y + kOn || std::max(ay, by) < y - kOn) continue;
    const auto x_at = [&](double height) {
      return ax + std::clamp((height - ay) / (by - ay), 0.0, 1.0) * (bx - ax);
    };
    if (std::abs(by - ay) <= kOn) {
      fill(std::min(ax, bx), std::max(ax, bx));
    } else {
      fill(std::min(x_at(y - kOn), x_at(y + kOn)), std::max(x_at(y - kOn), x_at(y + kOn)));
    }
    if ((ay > y) != (by > y)) crossings.push_back(x_at(y));
  }
  std::sort(crossings.begin(), crossings.end());
  for (std::size_t n = 1; n < crossings.size(); n += 2) fill(crossings[n - 1], crossings[n]);
  for (std::size_t c = 0; c < is_open.size(); ++c) is_open[c] = is_open[c] && inside[c];
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
  for (int row = 0; row < rows; ++row) {
    std::vector<char> is_open(std::size_t(columns), 1);
    for (const std::vector<double>& corners : shapes) cover_outside(corners, row, is_open);
    for (int c = 0; c < columns; ++c)
      if (is_open[std::size_t(c)]) {
        from[std::size_t(row) * std::size_t(columns) + std::size_t(c)] = row * columns + c;
        ++open;
      }
  }
  if (open == 0 || open == from.size()) return {};
  spread(from, columns, rows);
  return from;
}

}  // namespace angio::segmentation::detail
