#include "centerline/detail/contour.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace angio::centerline {
namespace {

double clearance(const Contour& contour, const Point2& p) {
  double least = 1e300;
  for (const Point2& q : contour)
    least = std::min(least, (q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y));
  return std::sqrt(least);
}

}  // namespace

ContourMoments contour_moments(const Contour& contour) {
  ContourMoments moments;
  double xx = 0.0, xy = 0.0, yy = 0.0;  // about the origin
  for (std::size_t i = 0; i < contour.size(); ++i) {
    const Point2 &a = contour[i], &b = contour[(i + 1) % contour.size()];
    const double twice = a.x * b.y - a.y * b.x;
    moments.area += 0.5 * twice;
    moments.middle.x += twice * (a.x + b.x) / 6.0;
    moments.middle.y += twice * (a.y + b.y) / 6.0;
    xx += twice * (a.x * a.x + a.x * b.x + b.x * b.x) / 12.0;
    yy += twice * (a.y * a.y + a.y * b.y + b.y * b.y) / 12.0;
    xy += twice * (2.0 * a.x * a.y + a.x * b.y + b.x * a.y + 2.0 * b.x * b.y) / 24.0;
  }
  if (moments.area <= 0.0) return {};
  moments.middle = {moments.middle.x / moments.area, moments.middle.y / moments.area};
  moments.xx = xx / moments.area - moments.middle.x * moments.middle.x;
  moments.yy = yy / moments.area - moments.middle.y * moments.middle.y;
  moments.xy = xy / moments.area - moments.middle.x * moments.middle.y;
  return moments;
}

double contour_extent(const Contour& contour, const Point2& from) {
  double extent = 0.0;
  for (const Point2& p : contour) extent = std::max(extent, std::hypot(p.x - from.x, p.y - from.y));
  return extent;
}

Circle largest_circle(const Contour& contour, double most_shift) {
  Circle best{{}, clearance(contour, {})};
  constexpr std::array<Point2, 8> kDirections{{{1, 0},
                                               {0, 1},
                                               {-1, 0},
                                               {0, -1},
                                               {0.7071, 0.7071},
                                               {-0.7071, 0.7071},
                                               {-0.7071, -0.7071},
                                               {0.7071, -0.7071}}};
  for (double step = 0.25 * best.radius; step > 1e-3 * best.radius;) {
    Circle better = best;
    for (const Point2& d : kDirections) {
      const Point2 trial{best.center.x + step * d.x, best.center.y + step * d.y};
      if (std::hypot(trial.x, trial.y) > most_shift) continue;
      const double r = clearance(contour, trial);
      if (r > better.radius) better = {trial, r};
    }
    if (better.radius > best.radius)
      best = better;
    else
      step *= 0.5;
  }
  return best;
}

Point2 section_middle(const Contour& contour, const Circle& largest, double most_shift,
                      double uncertainty) {
  constexpr double kAsWell = 0.95;
  const ContourMoments moments = contour_moments(contour);
  if (moments.area <= 0.0) return largest.center;
  const auto on_way = [&](double t) {
    return Point2{largest.center.x + t * (moments.middle.x - largest.center.x),
                  largest.center.y + t * (moments.middle.y - largest.center.y)};
  };
  const auto fits = [&](double t) {
    const Point2 trial = on_way(t);
    return std::hypot(trial.x, trial.y) <= most_shift &&
           clearance(contour, trial) >= kAsWell * largest.radius - uncertainty;
  };
  if (fits(1.0)) return on_way(1.0);
  double low = 0.0, high = 1.0;
  for (int pass = 0; pass < 12; ++pass)
    (fits(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  return on_way(low);
}

std::vector<double> polar_bias(const Contour& contour, double sd) {
  constexpr double kLeastCosine = 0.5, kMost = 0.1;  // of the radius: small errors are meant
  const std::size_t count = contour.size();
  std::vector<double> bias(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const Point2 &a = contour[(i + count - 1) % count], &p = contour[i],
                 &b = contour[(i + 1) % count];
    const Point2 first{p.x - a.x, p.y - a.y}, second{b.x - p.x, b.y - p.y};
    const double chord = std::hypot(b.x - a.x, b.y - a.y), r = std::hypot(p.x, p.y);
    const double length = 0.5 * (std::hypot(first.x, first.y) + std::hypot(second.x, second.y));
    if (r <= 0.0 || chord <= 0.0 || length <= 0.0) continue;
    const double bend = std::atan2(first.x * second.y - first.y * second.x,
                                   first.x * second.x + first.y * second.y) /
                        length;
    const double cosine =
        std::max((p.x * (b.y - a.y) - p.y * (b.x - a.x)) / (r * chord), kLeastCosine);
    const double square = cosine * cosine;
    const double sum = (1.0 / r - bend / cosine - 0.5 * bend * (1.0 - square) / cosine) / square;
    bias[i] = std::clamp(sd * sd * sum, -kMost * r, kMost * r);
  }
  return bias;
}

}  // namespace angio::centerline
