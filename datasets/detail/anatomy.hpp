#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/vec3.hpp"
#include "datasets/detail/lumen_shape.hpp"
#include "datasets/phantom.hpp"

/// The phantoms' shapes: which vessels, where, how wide, how narrowed.
namespace angio::datasets::detail {

/// Where a stenosis lies on its branch.
struct LesionSite {
  int branch = 0;
  double center_mm = 0.0;  ///< along the axis of the healthy branch
  double length_mm = 0.0;
};

struct Anatomy {
  LumenShape shape;
  std::vector<LesionSite> lesions;
};

/// Sizes of a phantom where the user gives none.
struct DefaultSize {
  std::string_view name;
  double radius_mm;              ///< at the inlet
  double length_mm;              ///< of the main branch
  double least_length_in_radii;  ///< shorter, and branches or the lesion would run into each other
};

/// @throws OptionError if there is no such phantom, with the nearest name
const DefaultSize& default_size(std::string_view name);

/// The options with the phantom's own size where it is left open, checked.
PhantomOptions with_size(const PhantomOptions& options);

/// The lumen of any phantom but the cloth. Branches divide by Murray's law, R0^3 = R1^3 + R2^3
/// (Murray, PNAS 12:207, 1926). A stenosis of depth S over a length of six radii:
///
///     w(s) = (1 + cos(2 pi (s - s0) / L)) / 2,    r(s) = R(s) (1 - S w(s))
///
/// Eccentric: the ball is shifted by R - r, so that it keeps touching the healthy wall on one side.
/// Two-sided: it slides by +- (R - r), which leaves a stadium of area pi r^2 + 4 r (R - r).
/// Concentric: it stays on the axis.
Anatomy make_anatomy(const PhantomOptions& options);

}  // namespace angio::datasets::detail
