#pragma once

#include <vector>

#include "core/centerline.hpp"
#include "meshing/detail/surface_target.hpp"

namespace angio::meshing::detail {

/// A curve with a frame that turns as little as possible along it.
struct FramedAxis {
  std::vector<Vec3> points;
  std::vector<Vec3> tangents, normals;  ///< unit, at right angles
  std::vector<double> abscissa;         ///< arc length from the first point [mm]
  /// Of the widest ring at each point: the gap to the wall is at least 15 % of the point's distance
  /// from it and 0.02 mm, and rings do not cross at bends. Negative where the axis leaves the
  /// lumen.
  std::vector<double> fitting_radius;  ///< [mm]

  [[nodiscard]] double length() const { return abscissa.back(); }
  [[nodiscard]] double narrowest() const;  ///< the least of the fitting radii [mm]
};

struct AxisFrame {
  Vec3 point, tangent, normal;
};
AxisFrame frame_at(const FramedAxis& axis, double abscissa);

/// The path smoothed by a Gaussian; beyond its ends it goes on straight.
/// @param sigma  standard deviation [mm], > 0
Vec3 smoothed_point(const CenterlinePath& path, double abscissa, double sigma);

/// The distance from the wall that a ring's axis needs, with the gap [mm].
double room_for(double radius);

/// What an axis is wanted for.
struct AxisWish {
  double middle_abscissa = 0.0;  ///< on the path [mm]
  double length = 0.0;           ///< [mm]
  double smoothing = 0.0;        ///< of the path: the Gaussian's usual standard deviation [mm]
  double radius = 0.0;           ///< that should fit around it everywhere [mm]
};

/// The path smoothed by a Gaussian, as far as bends ask for, and centred in the lumen where it is
/// narrow: the first of a few such axes around which the radius fits, else the roomiest.
///
/// @param wall  of the lumen
FramedAxis fit_axis(const AxisWish& wish, const CenterlinePath& path, const SurfaceTarget& wall);

}  // namespace angio::meshing::detail
