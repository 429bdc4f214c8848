#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

/// How even the surface of a vessel's wall is, whatever its width.
namespace angio::benchmarks {

/// The angle between the normals of the two triangles at each edge of unique_edges [degrees],
/// negative where the surface is hollow seen from outside, 0 at a rim.
std::vector<double> edge_bends(const TriangleMesh& mesh);

/// Longest side over least height, 1 for an equilateral triangle, shape [triangle_count].
///
///     sqrt(3)/2 l^2 / (2 A)
std::vector<double> triangle_aspects(const TriangleMesh& mesh);

/// A point of a tube's surface, and the tube's direction there, unit.
struct TubePoint {
  Vec3 point, along;
};

/// How far points of a tube lie off the smooth tube around them, root mean squares.
struct Unevenness {
  double mm = 0.0;
  double percent = 0.0;  ///< of the tube's radius at each point
};

/// Off the quadratic in angle and place along the tube that fits best the distances from the tube's
/// middle of all points within 45 degrees and 0.5 mm. A round or oval tube, a cone and a waist have
/// next to none, whatever their width; rows of points that stand in and out have their height.
/// Points with less than ten others near are left out.
Unevenness unevenness(const std::vector<TubePoint>& points);

/// What a plane cuts out of a tube.
struct TubeSection {
  double area_mm2 = 0.0;
  double roundness = 0.0;                      ///< 4 pi area / length^2, 1 of a circle
  double narrowest_mm = 0.0, widest_mm = 0.0;  ///< distances of parallel lines that hold it
};

/// Of the closed curves that a plane cuts out, the one whose middle is nearest to the plane's
/// origin; all 0 where there is none.
TubeSection section_of(const TriangleMesh& tube, const Vec3& origin, const Vec3& normal);

}  // namespace angio::benchmarks
