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

/// How far each vertex lies off the smooth tube around it [mm], shape [vertex_count]: off the
/// quadratic in angle and place along the vessel that fits best the distances from the tube's
/// middle of all that lies within 45 degrees and 0.5 mm. A round or oval tube, a cone and a waist
/// have next to none, whatever their width; rows of vertices that stand in and out have their
/// height. NaN outside of `chosen`, and where less than ten vertices are near.
///
/// @param along   unit, the vessel's direction at each vertex
/// @param chosen  which are measured, and looked at
std::vector<double> unevenness_mm(const TriangleMesh& mesh, const std::vector<Vec3>& along,
                                  const std::vector<char>& chosen);

/// Root of the mean square of those that are numbers; 0 where none is.
double root_mean_square(const std::vector<double>& values);

/// What a plane cuts out of a tube.
struct TubeSection {
  double area_mm2 = 0.0;
  double roundness = 0.0;  ///< 4 pi area / length^2, 1 of a circle
  double narrowest_mm = 0.0, widest_mm = 0.0;  ///< distances of parallel lines that hold it
};

/// Of the closed curves that a plane cuts out, the one whose middle is nearest to the plane's
/// origin; all 0 where there is none.
TubeSection section_of(const TriangleMesh& tube, const Vec3& origin, const Vec3& normal);

}  // namespace angio::benchmarks
