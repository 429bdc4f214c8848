#include "simulation/run/wire_track.hpp"

#include <algorithm>
#include <limits>

namespace angio::simulation::detail {
namespace {

/// Turns v by the least rotation that brings the unit vector a to the unit vector b (Rodrigues).
Vec3 turned(const Vec3& v, const Vec3& a, const Vec3& b) {
  const Vec3 axis = cross(a, b);  // of length sin
  const double cosine = dot(a, b);
  if (!(1.0 + cosine > 1e-9)) return v;  // opposite: no least rotation
  return cosine * v + cross(axis, v) + (dot(axis, v) / (1.0 + cosine)) * axis;
}

}  // namespace

WireTrack::WireTrack(const std::vector<Vec3>& points) {
  for (const Vec3& point : points) {
    const double step = points_.empty() ? 0.0 : distance(points_.back(), point);
    if (!points_.empty() && !(step > 0.0)) continue;
    abscissa_.push_back(points_.empty() ? 0.0 : abscissa_.back() + step);
    points_.push_back(point);
  }
}

WireTrack::Place WireTrack::at(double abscissa_mm) const {
  const auto behind = std::upper_bound(abscissa_.begin() + 1, abscissa_.end() - 1, abscissa_mm);
  const auto i = std::size_t(behind - abscissa_.begin());
  const Vec3 direction = normalized(points_[i] - points_[i - 1]);
  return {points_[i - 1] + (abscissa_mm - abscissa_[i - 1]) * direction, direction};
}

double WireTrack::abscissa_at(const Vec3& place) const {
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const double length = abscissa_[i] - abscissa_[i - 1];
    const Vec3 direction = normalized(points_[i] - points_[i - 1]);
    const double first = i == 1 ? -std::numeric_limits<double>::infinity() : 0.0;
    const double last = i + 1 == points_.size() ? std::numeric_limits<double>::infinity() : length;
    const double along = std::clamp(dot(place - points_[i - 1], direction), first, last);
    const double away = distance(place, points_[i - 1] + along * direction);
    if (away < least) {
      least = away;
      best = abscissa_[i - 1] + along;
    }
  }
  return best;
}

Vec3 WireTrack::carried(const Vec3& place, double distance_mm) const {
  if (points_.size() < 2) return place;
  const double from = abscissa_at(place);
  const Place here = at(from), there = at(from + distance_mm);
  return there.point + turned(place - here.point, here.direction, there.direction);
}

}  // namespace angio::simulation::detail
