#pragma once

#include <string>
#include <vector>

#include "core/surface_rims.hpp"
#include "core/triangle_mesh.hpp"
#include "core/units.hpp"

namespace angio::meshing {

/// How large a surface is, in the unit of its coordinates.
struct SurfaceSize {
  Vec3 low, high;       ///< corners of its box
  double extent = 0.0;  ///< the box's longest side
  double area = 0.0;
  double volume = 0.0;  ///< inside, openings closed by the shortest way
  /// Diameters of the largest balls that touch the wall from inside, by share of the wall's area:
  /// 5, 50 and 98 % of it see one as wide or less. 0 where there is none.
  double thin = 0.0, median = 0.0, wide = 0.0;
  /// Of the area, whose outside is a hollow that the surface closes around. Above a quarter the
  /// surface is that of a vessel's wall, and its lumen is the hollow; of a lumen there is none.
  double hollow_share = 0.0;
  std::vector<SurfaceRim> rims;  ///< the longest first

  void scale(double factor);  ///< to another unit
};

/// Measures a manifold surface whose normals leave the lumen.
///
/// The balls shrink from the whole surface's size until they touch it at their own point and one
/// other (Ma, Bae, Choi, "3D medial axis point approximation using nearest neighbors and the normal
/// field", The Visual Computer 28, 2012); a second touch that the ball's centre sees less than 60
/// degrees from the first is the wall's own roughness and does not shrink it further. Up to 2000
/// triangles are looked at, spread evenly over the area.
SurfaceSize measure_surface(const TriangleMesh& surface);

/// The lumen's surface in that of a vessel's wall (SurfaceSize::hollow_share): its inner side, open
/// at the vessel's ends, normals leaving the lumen. Empty where the wall is around nothing.
TriangleMesh lumen_of_wall(const TriangleMesh& wall);

/// Whether a surface that was measured is that of a vessel's wall.
bool is_wall(const SurfaceSize& size);

/// The median diameter alone, from 300 triangles; 0 where there is none.
double median_diameter(const TriangleMesh& surface);

/// "2.9 mm wide at most, 1.8 mm in the median, 120 mm long": a surface whose coordinates are in
/// this unit.
std::string size_in_words(const SurfaceSize& size, LengthUnit unit);

/// Could a surface whose coordinates are in this unit be a vessel that was imaged in a patient and
/// that a balloon is made for?
///
/// - Its wide diameter is 1.5 to 80 mm: no balloon is made for thinner vessels, and no aneurysm of
///   the aorta is wider.
/// - Its median diameter is 0.8 to 60 mm: no clinical scanner shows finer trees (voxels of 0.2 mm,
///   and a lumen needs some across).
/// - It is 4 to 1200 mm long: up to an aorta with the arteries of both legs. How short a piece is
///   cut says little.
/// - In another unit than mm its x and y lie within 500 mm of the origin: that is a scanner's
///   largest field of view, and images have their origin in its middle or at its corner.
bool is_possible(const SurfaceSize& size, LengthUnit unit);

/// What a surface seems to be measured in.
struct UnitGuess {
  LengthUnit unit = LengthUnit::mm;
  bool is_vessel = false;          ///< false: it is no possible vessel in any unit
  std::vector<LengthUnit> others;  ///< in which it would be a vessel, too; none: certain
};

/// The unit, mm, cm or m, in which a surface has a vessel's size. Several can: a coronary in mm has
/// the numbers of an aorta in cm. Then that one is taken in which the size is a usual one (2.5 to
/// 60 mm wide, 1.2 to 35 mm in the median, up to 600 mm long: from the coronaries and the arteries
/// of the brain to the aorta), and mm if it still is one of several. So what may be wrong is what
/// is told: a tree in mm whose widest vessel is below 2.5 mm (unless it would be over 600 mm long
/// in the others), and an aorta in cm that is wider.
/// What is a vessel in no unit where it lies has been moved: then its place says nothing.
UnitGuess guess_unit(const SurfaceSize& size);

}  // namespace angio::meshing
