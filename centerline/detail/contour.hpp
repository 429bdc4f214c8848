#pragma once

#include <vector>

namespace angio::centerline {

/// A place in the plane of a section [mm].
struct Point2 {
  double x = 0.0, y = 0.0;
};

/// A closed line round the origin, counter-clockwise, its last point not repeated.
using Contour = std::vector<Point2>;

/// Area and moments of what a contour encloses.
struct ContourMoments {
  double area = 0.0;                    ///< [mm^2]
  Point2 middle;                        ///< centroid
  double xx = 0.0, xy = 0.0, yy = 0.0;  ///< central second moments over the area [mm^2]
};
ContourMoments contour_moments(const Contour& contour);

/// The greatest distance of a contour from a point in it [mm].
double contour_extent(const Contour& contour, const Point2& from);

/// A circle inside a contour.
struct Circle {
  Point2 center;
  double radius = 0.0;
};

/// The largest circle inside a contour whose centre is at most `most_shift` from the origin.
Circle largest_circle(const Contour& contour, double most_shift);

/// The point from which a line through the section is drawn: the centroid, as long as a circle
/// round it is nearly as large as the largest one; else the nearest such point to the centroid on
/// the way from the largest circle's centre. In a round section both are the same, in a flat one
/// (where many circles fit as well) the line does not wander along the flat, and in a crescent it
/// stays inside.
///
/// @param uncertainty  of the contour [mm]: circles are as large when they differ by less
Point2 section_middle(const Contour& contour, const Circle& largest, double most_shift,
                      double uncertainty = 0.0);

/// What errors of single vertices along the wall's normal add to the radii of a fit in polar
/// coordinates, with alpha from the radius to the normal and the contour's curvature k:
///
///     sd^2 (1 / (r cos^2 a) - k / cos^3 a - k tan^2 a / (2 cos a))
///
/// The third term is the bend of r with the error; the others come from what is seen at an angle: a
/// vertex that errs outwards on a flat wall has come from nearer to the middle, where an angle
/// holds more of the wall. On a circle round the origin it is 0, on a flat wall sd^2 / (r cos^2 a).
///
/// @param sd  [mm]
std::vector<double> polar_bias(const Contour& contour, double sd);

}  // namespace angio::centerline
