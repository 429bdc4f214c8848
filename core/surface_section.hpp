#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/triangle_mesh.hpp"

/// What a plane cuts out of a surface.
namespace angio {

/// A curve of straight pieces.
struct SurfaceSection {
  Vec3 normal;  ///< of the plane, unit
  Vec3 middle;  ///< of the curve, by its length [mm]
  /// Enclosed [mm^2]; where the curve is open at a rim, with the fan from `middle` in place of
  /// what is missing.
  double area = 0.0;
  bool is_closed = false;
  std::vector<std::array<Vec3, 2>> pieces;  ///< [mm], in no order
};

/// Of the curves that a plane through a point cuts out of a surface, the one whose middle is
/// nearest to the point.
///
/// @param triangles  into x
/// @param normal     of the plane, unit
/// @return nothing where no plane meets the surface
std::optional<SurfaceSection> nearest_section(const std::vector<Triangle>& triangles,
                                              const std::vector<Vec3>& x, const Vec3& point,
                                              const Vec3& normal);

/// The radius of the largest circle in a section [mm], within 0.2 % of that of a circle of its
/// area: the pole of inaccessibility (Garcia-Castellanos, Lombardo, Scottish Geographical Journal
/// 123(3), 2007, 227-233), found in ever smaller squares, the most promising first.
/// @return 0: the curve is not closed
double inscribed_radius(const SurfaceSection& section);

/// The shortest and the longest chord through the centroid of what a section encloses [mm].
struct SectionWidths {
  double least = 0.0, greatest = 0.0;

  /// (greatest - least) / greatest: 0 of a circle. The lumen eccentricity of intravascular
  /// ultrasound: Mintz et al., J. Am. Coll. Cardiol. 37(5), 2001, 1478-1492,
  /// doi:10.1016/S0735-1097(01)01175-5.
  [[nodiscard]] double eccentricity() const { return (greatest - least) / greatest; }
};

/// By 90 directions over half a circle; towards each side the farthest piece counts.
/// @return nothing where a direction meets no piece
std::optional<SectionWidths> section_widths(const SurfaceSection& section);

}  // namespace angio
