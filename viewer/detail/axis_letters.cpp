#include "viewer/detail/axis_letters.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace angio::viewer::detail {
namespace {

constexpr double kApart = 0.36;     // two letters
constexpr double kOffAxis = 0.22;   // a letter and another axis
constexpr double kFarthest = 1.35;  // from the origin along x and y

double distance(const AxisSpot& a, const AxisSpot& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1]);
}

/// From a place to the line from the origin to a tip.
double distance_to_axis(const AxisSpot& p, const AxisSpot& tip) {
  const double length_squared = tip[0] * tip[0] + tip[1] * tip[1];
  const double share = length_squared > 0.0
                           ? std::clamp((p[0] * tip[0] + p[1] * tip[1]) / length_squared, 0.0, 1.0)
                           : 0.0;
  return distance(p, {share * tip[0], share * tip[1]});
}

/// Beyond the tip first, then around it, then farther away.
std::vector<AxisSpot> spots_around(const AxisSpot& tip) {
  constexpr int kDirections = 16;
  constexpr double kTurn = 6.283185307179586 / kDirections;
  const double length = std::hypot(tip[0], tip[1]);
  // At the origin to the lower left, where the other two axes seldom are.
  const double outwards = length > 0.05 ? std::atan2(tip[1], tip[0]) : -2.4;
  std::vector<AxisSpot> places;
  for (const double away : {0.25, 0.4, 0.6})
    for (int d = 0; d < kDirections; ++d) {
      const int turn = d % 2 == 0 ? d / 2 : -(d + 1) / 2;  // to both sides
      const double angle = outwards + turn * kTurn;
      places.push_back({tip[0] + away * std::cos(angle), tip[1] + away * std::sin(angle)});
    }
  return places;
}

}  // namespace

std::array<AxisSpot, 3> place_axis_letters(const std::array<AxisSpot, 3>& tips) {
  std::array<std::size_t, 3> order{0, 1, 2};  // the longest first: theirs is the least choice
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::hypot(tips[a][0], tips[a][1]) > std::hypot(tips[b][0], tips[b][1]);
  });
  std::array<AxisSpot, 3> letters{};
  for (std::size_t n = 0; n < order.size(); ++n) {
    const std::size_t axis = order[n];
    double least = std::numeric_limits<double>::infinity();
    for (const AxisSpot& place : spots_around(tips[axis])) {
      double fault = 0.0;  // how far it is from being right
      for (std::size_t m = 0; m < n; ++m)
        fault += 10.0 * std::max(0.0, kApart - distance(place, letters[order[m]]));
      for (std::size_t other = 0; other < tips.size(); ++other)
        fault += std::max(
            0.0, (other == axis ? 0.9 : 1.0) * kOffAxis - distance_to_axis(place, tips[other]));
      for (const double x : place) fault += 10.0 * std::max(0.0, std::abs(x) - kFarthest);
      if (fault >= least) continue;
      least = fault;
      letters[axis] = place;
    }
  }
  return letters;
}

}  // namespace angio::viewer::detail
