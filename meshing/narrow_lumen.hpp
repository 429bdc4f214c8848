#pragma once

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::meshing {

/// A stenosis to be made where there is none.
struct NarrowingOptions {
  double percent = 0.0;    ///< of the diameter, 0 or [5, 100]; 0: none
  double length_mm = 0.0;  ///< from edge to edge, 0 or [1, 100]; 0: three diameters

  void validate() const;
};

/// Where and how wide.
struct Narrowing {
  int path_id = 0;
  double abscissa_mm = 0.0;  ///< of its tightest place
  double length_mm = 0.0;
  double diameter_mm = 0.0;  ///< inscribed, at that place, before
};

/// The middle of the longest branch of suitable width (a healthy inscribed diameter from 2.25 to 5
/// mm, the usual balloons'), the widest if none is suitable; or the place given.
///
/// @param path_id      the line to choose from; -1: any
/// @param abscissa_mm  on it; negative: the middle of the longest branch
/// @throws OptionError if no line has that id, or the line is too short
Narrowing choose_narrowing(const CenterlineTree& tree, const NarrowingOptions& options, int path_id,
                           double abscissa_mm);

/// Draws the wall towards the line. A vertex whose nearest point of the line m(s) lies at s, at the
/// distance d, with the lumen's radius R(s) there:
///
///     x' = m + (x - m) (1 - S w(s) f(d / R)),   w = (1 + cos(2 pi (s - s0) / L)) / 2
///
/// with f = 1 on the wall of the vessel itself (up to 1.6 R), falling smoothly to 0 at 3 R, so that
/// other vessels stay where they are.
TriangleMesh narrow_lumen(const TriangleMesh& surface, const CenterlinePath& path,
                          const Narrowing& narrowing, double percent);

}  // namespace angio::meshing
