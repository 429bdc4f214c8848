#pragma once

#include <vector>

#include "core/vec3.hpp"

namespace angio::simulation::detail {

/// A curve along which a body is carried.
class WireTrack {
 public:
  /// @param points  along the curve [mm]; equal neighbours are left out
  explicit WireTrack(const std::vector<Vec3>& points);

  [[nodiscard]] double length_mm() const { return abscissa_.empty() ? 0.0 : abscissa_.back(); }
  /// Of the point of the curve nearest to a place.
  [[nodiscard]] double abscissa_at(const Vec3& place) const;
  /// Carries a place along by a distance. With c(s) the curve, t(s) its direction, s the abscissa
  /// nearest to the place p, and R the least rotation that turns t(s) into t(s + d):
  ///
  ///     p' = c(s + d) + R (p - c(s))
  ///
  /// Beyond its ends the curve goes on straight.
  [[nodiscard]] Vec3 carried(const Vec3& place, double distance_mm) const;

 private:
  struct Place {
    Vec3 point, direction;
  };
  [[nodiscard]] Place at(double abscissa_mm) const;

  std::vector<Vec3> points_;
  std::vector<double> abscissa_;
};

}  // namespace angio::simulation::detail
