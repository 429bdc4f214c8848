#pragma once

#include <vector>

#include "centerline/detail/wall.hpp"

namespace angio::centerline {

/// What a plane through a lumen shows.
struct Section {
  bool valid = false;             ///< false when the centre is outside the lumen
  Vec3 center;                    ///< of the largest circle near the point that was asked for
  double inscribed_radius = 0.0;  ///< of that circle [mm]
  double extent = 0.0;            ///< half the width where it is widest [mm]
  double area = 0.0;              ///< [mm^2]
};

struct SectionOptions {
  int ray_count = 32;
  int refinements = 1;      ///< how often the rays are sent again from the new centre
  double expected = 1.0;    ///< the radius so far [mm]; rays end at kLongestRay times this
  double extent = 0.0;      ///< half the width so far [mm], where it is more than the radius
  double most_shift = 0.5;  ///< of the centre, in radii
};

/// Rays end at this many inscribed radii: where a plane runs along another branch, the section is
/// finite.
inline constexpr double kLongestRay = 4.0;

/// Measures the section of the lumen by a plane.
///
/// Rays from the centre reach the wall at r(theta). Its harmonics up to order 4, fitted robustly
/// (Huber weights, so that single bumps of a noisy surface count little), give a smooth contour;
/// the largest circle inside that contour has the inscribed radius. The plain minimum of r would be
/// too low by two or three standard deviations of the noise. The area is that of the star-shaped
/// polygon of the rays themselves, 1/2 sum r_i r_(i+1) sin(2 pi / n), scaled to the circle that
/// the polygon inscribes.
Section measure_section(const Wall& wall, const Vec3& point, const Vec3& normal,
                        const SectionOptions& options);

}  // namespace angio::centerline
