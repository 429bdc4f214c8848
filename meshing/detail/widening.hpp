#pragma once

#include <vector>

#include "core/centerline.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing::detail {

/// The shape that triangles are to have where a balloon will widen the lumen.
///
/// A throat of radius r that is opened to R stretches what lies around it by R / r and leaves what
/// lies along it. Triangles that are well shaped now are R / r times as wide as long then; those
/// that would be well shaped then are it now, the other way. Half way between both, lengths along
/// the vessel count
///
///     k = max(sqrt(r / R), 0.4)
///
/// times their size: a triangle that is equilateral so is never further from it than sqrt(R / r),
/// before or after. 0.4 leaves it 26 degrees now, and what remeshing makes of it 20, as flow
/// solvers ask for.
class Widening {
 public:
  Widening() = default;
  Widening(const CenterlineTree& tree, const std::vector<WidenedStretch>& stretches);

  [[nodiscard]] bool is_none() const { return lines_.empty(); }

  /// What shortens lengths at a point: a vector w along the vessel, 0 where nothing is widened. An
  /// edge e counts as
  ///
  ///     e - (e . w) w,   |w|^2 = 1 - k
  [[nodiscard]] Vec3 at(const Vec3& point) const;
  /// Shape [point_count]; all 0 if there is none.
  [[nodiscard]] std::vector<Vec3> at(const std::vector<Vec3>& points) const;

 private:
  struct Line {
    CenterlinePath path;  ///< of the stretch alone
    double radius = 0.0;  ///< that it will have [mm]
  };
  std::vector<Line> lines_;
};

/// An edge as it counts. @param w  Widening::at
inline Vec3 shortened(const Vec3& edge, const Vec3& w) { return edge - dot(edge, w) * w; }

}  // namespace angio::meshing::detail
