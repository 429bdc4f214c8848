#include "centerline/detail/point_row.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace angio::centerline {
namespace {

constexpr std::size_t kRun = 16;

}  // namespace

PointRow::PointRow(std::vector<Vec3> points) : points_(std::move(points)) {
  for (std::size_t first = 0; first < points_.size(); first += kRun) {
    const std::size_t last = std::min(first + kRun, points_.size());
    Ball ball{points_[(first + last) / 2], 0.0};
    for (std::size_t i = first; i < last; ++i)
      ball.radius = std::max(ball.radius, distance(points_[i], ball.middle));
    balls_.push_back(ball);
  }
}

std::size_t PointRow::nearest(const Vec3& place) const {
  constexpr double kRounding = 1.0 + 1e-9;
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity(), squared_least = least;
  for (std::size_t run = 0; run < balls_.size(); ++run) {
    const Ball& ball = balls_[run];
    const double reach = kRounding * (least + ball.radius);
    if (norm_squared(place - ball.middle) > reach * reach) continue;
    for (std::size_t i = run * kRun; i < std::min((run + 1) * kRun, points_.size()); ++i)
      if (const double squared = norm_squared(points_[i] - place); squared < squared_least) {
        squared_least = squared;
        nearest = i;
      }
    least = std::sqrt(squared_least);
  }
  return nearest;
}

}  // namespace angio::centerline
