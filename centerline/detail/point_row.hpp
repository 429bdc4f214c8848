#pragma once

#include <cstddef>
#include <vector>

#include "core/vec3.hpp"

namespace angio::centerline {

/// Points in a row, in which the nearest to a place is looked for: runs of them lie in balls, and
/// those of balls that are too far are not looked at.
class PointRow {
 public:
  PointRow() = default;
  explicit PointRow(std::vector<Vec3> points);

  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] const Vec3& operator[](std::size_t i) const { return points_[i]; }
  [[nodiscard]] const Vec3& front() const { return points_.front(); }
  [[nodiscard]] const Vec3& back() const { return points_.back(); }

  /// The index of the nearest point, the first of those as near; 0 in an empty row.
  [[nodiscard]] std::size_t nearest(const Vec3& place) const;

 private:
  struct Ball {
    Vec3 middle;
    double radius = 0.0;
  };
  std::vector<Vec3> points_;
  std::vector<Ball> balls_;  ///< of kRun points each
};

}  // namespace angio::centerline
