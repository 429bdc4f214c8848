#pragma once

#include <functional>
#include <vector>

#include "core/vec3.hpp"

namespace angio::centerline {

/// Points with the size of the vessel at each.
struct Polyline {
  std::vector<Vec3> points;    ///< LPS [mm]
  std::vector<double> radius;  ///< inscribed [mm]
  std::vector<double> extent;  ///< half the section's width where it is widest [mm]: the radius of
                               ///< a round vessel; how far along the line a direction is taken

  void push_back(const Vec3& point, double r) {
    points.push_back(point);
    radius.push_back(r);
    extent.push_back(r);
  }
  void resize(std::size_t count) {
    points.resize(count);
    radius.resize(count);
    extent.resize(count);
  }
  void erase(std::size_t first, std::size_t last);  ///< points [first, last)
};

void reverse(Polyline& line);

/// The stretch whose direction counts for that of a point: a radius to each side, and more where
/// the lumen is flat, because there a line that turns a little within the flat moves its own
/// sections, and turns more.
double direction_reach(const Polyline& line, std::size_t i);

/// Unit tangent at point i: the chord from `reach` [mm] before it to `reach` after it.
/// @param s  arc lengths of the points
Vec3 tangent_at(const Polyline& line, const std::vector<double>& s, std::size_t i, double reach);

/// Unit tangent at the last point, away from the line, over its last `reach` [mm].
Vec3 end_tangent(const Polyline& line, double reach);

/// True when a point is inside the tube round a line from point `from` on: the union of the cones
/// between its spheres.
bool inside_tube(const std::vector<Vec3>& points, const std::vector<double>& radius,
                 std::size_t from, const Vec3& point);

/// Moves points [fixed, last) half way to the middle of their neighbours, `passes` times.
void smooth(Polyline& line, std::size_t fixed, int passes);

/// The same for radius and extent alone.
void smooth_widths(Polyline& line, std::size_t fixed, int passes);

/// Puts points anew behind point fixed - 1 (or 0), `step(radius)` [mm] apart, on the Catmull-Rom
/// curve through the points. The first `fixed` points and the last one stay.
void resample(Polyline& line, std::size_t fixed, const std::function<double(double)>& step);

/// A cubic Hermite curve between two points, without them. Tangents are scaled to the chord.
std::vector<Vec3> bridge(const Vec3& from, const Vec3& from_tangent, const Vec3& to,
                         const Vec3& to_tangent, int count);

}  // namespace angio::centerline
