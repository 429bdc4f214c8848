#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::benchmarks {

/// A stenosis that was put into a vessel.
struct Narrowing {
  Vec3 place;  ///< its tightest place on the line [mm]
  double diameter_mm = 0.0, percent = 0.0, length_mm = 0.0;
  double eccentricity = 0.0;  ///< 0: from all sides; 1: the wall stays on one side
};

/// Where stenoses are put, and how long they are.
enum class Site {
  even,   ///< a diameter or more from a branching, where the vessel is even over two diameters to
          ///< both sides; 2 to 5 diameters long from shoulder to shoulder
  beside  ///< an eighth to a whole diameter from a branching; 0.75 to 2 diameters long
};

/// Puts up to three stenoses into a surface, at random places of its lines, eight diameters from
/// each other: 40 to 90 %, so that 0.5 mm or more are left. A place is fit if the vessel is 1.5 mm
/// or more wide there, and three diameters from an end and from every place that is taken.
std::vector<Narrowing> narrow_vessels(TriangleMesh& surface, const CenterlineTree& lines,
                                      const std::vector<Vec3>& taken, Site site,
                                      std::mt19937_64 random);

}  // namespace angio::benchmarks
