#pragma once

#include <array>
#include <vector>

#include "centerline/detail/contour.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/wall.hpp"
#include "centerline/detail/wall_points.hpp"

namespace angio::centerline {

/// A line around one of its points: c(s) = origin + c1 s + c2 s^2 + c3 s^3, least squares through
/// the neighbouring points, so that single points do not turn the section.
struct LocalCurve {
  Vec3 origin, c1, c2, c3;
  double first = 0.0, last = 0.0;  ///< where the line begins and ends [mm], 0 is the origin
  Vec3 u, v;                       ///< span the section's plane at s = 0

  [[nodiscard]] Vec3 at(double s) const { return origin + s * (c1 + s * (c2 + s * c3)); }
  [[nodiscard]] Vec3 tangent(double s) const {
    return normalized(c1 + s * (2.0 * c2 + (3.0 * s) * c3));
  }
};

/// @param s  arc lengths of the line's points
/// @param reach  how far to each side points count [mm]
LocalCurve fit_curve(const Polyline& line, const std::vector<double>& s, std::size_t i,
                     double reach);

inline constexpr int kSectors = 24;  ///< of the coarse look at the wall

/// A wall point in the frame of the line.
struct Sample {
  double s = 0.0, x = 0.0, y = 0.0;  // along and across the line [mm]
  double radius = 0.0, cos = 1.0, sin = 0.0;
  double angle = 0.0;   // whose cosine and sine these are, in [-pi, pi]
  double weight = 1.0;  // robust
};

/// Stretches the plane so that a flat section becomes a round one of the same area.
struct Stretch {
  double xx = 1.0, xy = 0.0, yy = 1.0;  // symmetric, determinant 1
  [[nodiscard]] Point2 apply(const Point2& p) const {
    return {xx * p.x + xy * p.y, xy * p.x + yy * p.y};
  }
  [[nodiscard]] Point2 undo(const Point2& p) const {
    return {yy * p.x - xy * p.y, xx * p.y - xy * p.x};
  }
};

void set_polar(Sample& sample, const Stretch& stretch);

/// The wall points round a line, up to `reach` [mm] along it and `widest` [mm] from it.
/// @param radius  of the vessel so far [mm]
std::vector<Sample> gather(const WallPoints& points, const LocalCurve& curve, double radius,
                           double reach, double widest);

/// How far away the wall is all round, sector by sector.
struct Coarse {
  std::array<double, kSectors> radius{};   // lower quartile; 0 where nothing is seen
  std::array<double, kSectors> longest{};  // what lies farther is seen through an opening
  double typical = 0.0;
  double noise = 0.0;  // sd of the points about the wall [mm]
  int gap = kSectors;  // longest run of sectors without wall
};

Coarse look_round(const std::vector<Sample>& samples, double window);

/// Whether no wall is seen to one side and none near to the other, as from within a slit.
bool is_open_to_both_sides(const Coarse& coarse);

/// Leaves out what lies behind the first wall: other vessels, and the far side of a branching.
void keep_first_wall(std::vector<Sample>& samples, const Coarse& coarse);

/// Leaves out points that another wall hides from the line.
void keep_visible(std::vector<Sample>& samples, const LocalCurve& curve, const Wall& wall);

/// What makes a flat section round: the inverse root of its second moments.
Stretch find_stretch(const Coarse& coarse);

/// The value below which the part q of the values lies; turns their order.
double quantile(std::vector<double>& values, double q);

}  // namespace angio::centerline
