#pragma once

#include <array>
#include <optional>
#include <vector>

#include "viewer/detail/plane.hpp"
#include "viewer/report.hpp"

/// Planes at right angles to the treated line, and what of the lumen lies in them.
namespace angio::viewer::detail {

struct PathSection {
  PlaneWindow window;
  double abscissa_mm = 0.0;
};

/// The widest radius within a distance of a place on the line [mm], at least 0.1.
double widest_near(const CenterlinePath& path, double abscissa_mm, double reach_mm);

/// How far to each side of the lesion sections are shown: over what was measured before and after,
/// otherwise three of the widest radii near the lesion [mm].
double shown_reach(const ReportContent& content, const CenterlinePath& path);

/// Abscissas over that reach around a place, ascending, the place in the middle.
/// @param count  odd, 3 or more
std::vector<double> places_around(const ReportContent& content, const CenterlinePath& path,
                                  double middle_mm, int count);

/// The same around the lesion.
std::vector<double> places_around_lesion(const ReportContent& content, const CenterlinePath& path,
                                         int count);

/// The planes there. "Right" is carried along the line without turning about it, so that neighbours
/// are not turned against each other; all are of one size, 1.7 of the widest radius to each side.
/// @param abscissas  ascending, not empty
std::vector<PathSection> path_sections(const ReportContent& content, const CenterlinePath& path,
                                       const std::vector<double>& abscissas);

/// The triangles with a corner within the reach of the lesion's sections.
TriangleMesh near_sections(const TriangleMesh& mesh, const std::vector<PathSection>& sections);

/// A point of a section, to the right and down of its middle [mm].
using SectionPoint = std::array<double, 2>;

/// Where a surface meets a section's plane, within its window: lines of points that follow each
/// other, closed ones with their first point again at the end.
std::vector<std::vector<SectionPoint>> section_contours(const TriangleMesh& mesh,
                                                        const PlaneWindow& window);

/// Where the contours cross an axis through the section's middle, nearest to it on both sides: left
/// and right [mm], or up and down. Unset where one side has none.
/// @param axis  0: to the right, 1: down
std::optional<std::array<double, 2>> nearest_edges(
    const std::vector<std::vector<SectionPoint>>& contours, std::size_t axis);

}  // namespace angio::viewer::detail
