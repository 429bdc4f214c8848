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

}  // namespace angio::centerline
