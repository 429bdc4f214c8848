#include "viewer/detail/chart_labels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace angio::viewer::detail {
namespace {

constexpr double kAscent = 12.0, kDescent = 4.0;  // of letters [px]
constexpr double kPointSpacing = 3.0;             // along a line [px]

bool overlap(const LabelBox& a, const LabelBox& b) {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

bool is_inside(const LabelBox& box, const LabelBox& area) {
  return box.left >= area.left && box.right <= area.right && box.top >= area.top &&
         box.bottom <= area.bottom;
}

}  // namespace

LabelBox box_of(const LabelPlace& place, double width) {
  const double left = place.anchor == LabelPlace::Anchor::end      ? place.x - width
                      : place.anchor == LabelPlace::Anchor::middle ? place.x - 0.5 * width
                                                                   : place.x;
  return {left, left + width, place.y - kAscent, place.y + kDescent};
}

double distance_to(const LabelBox& box, double x, double y) {
  return std::hypot(std::max({box.left - x, x - box.right, 0.0}),
                    std::max({box.top - y, y - box.bottom, 0.0}));
}

void ChartLabels::keep_off(const std::vector<std::array<double, 2>>& points) {
  const auto is_there = [](const std::array<double, 2>& p) {
    return std::isfinite(p[0]) && std::isfinite(p[1]);
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_there(points[i])) continue;
    lines_.push_back(points[i]);
    if (i == 0 || !is_there(points[i - 1])) continue;
    const auto& [x0, y0] = points[i - 1];
    const auto& [x1, y1] = points[i];
    const int parts = int(std::hypot(x1 - x0, y1 - y0) / kPointSpacing);
    for (int part = 1; part <= parts; ++part) {
      const double share = double(part) / (parts + 1);
      lines_.push_back({x0 + share * (x1 - x0), y0 + share * (y1 - y0)});
    }
  }
}

LabelPlace ChartLabels::place(const std::vector<LabelPlace>& wanted, double width) {
  LabelPlace chosen = wanted.back();
  double least = std::numeric_limits<double>::infinity();
  for (const LabelPlace& place : wanted) {
    const LabelBox box = box_of(place, width);
    const bool is_free = std::none_of(taken_.begin(), taken_.end(),
                                      [&](const LabelBox& other) { return overlap(box, other); });
    if (!is_free || !is_inside(box, area_)) continue;
    const auto under = std::count_if(lines_.begin(), lines_.end(), [&](const auto& p) {
      return p[0] > box.left && p[0] < box.right && p[1] > box.top && p[1] < box.bottom;
    });
    if (place.cost + double(under) >= least) continue;
    least = place.cost + double(under);
    chosen = place;
  }
  taken_.push_back(box_of(chosen, width));
  return chosen;
}

}  // namespace angio::viewer::detail
