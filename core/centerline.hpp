#pragma once

#include <vector>

#include "core/vec3.hpp"

namespace angio {

/// A stretch of one line between branchings, as VMTK's branch extractor names it. Consecutive
/// tracts share their border point: [first_point, last_point] is inclusive on both sides.
struct CenterlineTract {
  int first_point = 0;
  int last_point = 0;
  int group_id = 0;       ///< equal for tracts of different lines that run through one branch
  int tract_id = 0;       ///< 0, 1, ... along the line
  bool blanking = false;  ///< true inside a branching, where no branch owns the lumen
};

/// One line from the inlet to one outlet. All arrays have shape [point_count].
struct CenterlinePath {
  int id = 0;                            ///< CenterlineIds
  std::vector<Vec3> points;              ///< LPS [mm]
  std::vector<double> inscribed_radius;  ///< distance to the wall: of the largest sphere [mm]
  /// The same in the tube fitted to the wall, so freed of the wall's noise [mm]; the inscribed one
  /// where no section was seen all round. Empty: not known.
  std::vector<double> tube_radius;
  std::vector<double> abscissa;           ///< arc length from the inlet [mm]
  std::vector<double> section_area;       ///< of the plane section normal to the line [mm^2]
  std::vector<double> equivalent_radius;  ///< sqrt(section_area / pi) [mm]
  std::vector<CenterlineTract> tracts;    ///< cover the line without gaps
};

/// The radius to measure a lumen's width by: the tube's where it is known, else the inscribed one.
const std::vector<double>& measured_radius(const CenterlinePath& path);

/// The tree: every path begins at the inlet; shared stretches carry the same points.
struct CenterlineTree {
  std::vector<CenterlinePath> paths;  ///< the longest first
};

/// A place on a line, between its points.
struct CenterlineSample {
  Vec3 point;                      ///< LPS [mm]
  Vec3 tangent;                    ///< unit, away from the inlet
  double inscribed_radius = 0.0;   ///< [mm]
  double equivalent_radius = 0.0;  ///< [mm]
};

/// Linear interpolation along a line; beyond its ends, the end point and its tangent.
///
/// @param path      at least two points
/// @param abscissa  [mm] from the inlet
CenterlineSample sample(const CenterlinePath& path, double abscissa);

/// The abscissa [mm] of the point of the line nearest to `point`.
double project(const CenterlinePath& path, const Vec3& point);

enum class PathEnd { inlet, outlet };

/// The radius of the vessel where a line begins or ends [mm]: of the widest ball on the line that,
/// 1.7 times as large, reaches that end. (The inscribed radius at the last point itself goes to
/// zero in a closed end, by the cosine of its slant along the axis.)
double radius_at_end(const CenterlinePath& path, PathEnd end);

/// Arc length of a polyline at each of its points [mm], starting at 0.
std::vector<double> arc_length(const std::vector<Vec3>& points);

}  // namespace angio
