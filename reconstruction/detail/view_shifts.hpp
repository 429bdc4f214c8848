#pragma once

#include <vector>

#include "core/vec3.hpp"
#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/views.hpp"

namespace angio::reconstruction::detail {

/// By how much the table moved between views, as far as they tell.
struct ViewShifts {
  std::vector<Vec3> shift;          ///< of each view's C-arm against the patient [mm]; first: none
  double agreement_as_given = 0.0;  ///< of neighbouring views' profiles, least of them, [-1, 1]
  double agreement = 0.0;           ///< after the shifts
  double ends_apart_mm = 0.0;       ///< how far the vessel's ends disagree about a shift, the most
};

/// A plane through the sources of two views cuts the same part of the patient in both: across it
/// they must show equally much contrast medium, sum over the plane's line of p (the zeroth of the
/// consistency conditions of Clackdoyle, Desbat, IEEE Trans. Nucl. Sci. 60:1560, 2013, in small
/// cones). Each view's profile over these planes is laid over those of the views before it; how far
/// it must be moved for the best correlation tells its shift across the planes, and by all of them,
/// least squares of the least length. Along the planes a shift changes where the vessels seem to
/// lie, and nothing else.
///
/// A shift is taken only where it makes the correlation better by `kWorthIt`.
///
/// @param ends  of the one vessel that the views' lines are of, one a view: a shift is looked for
///              around the one that they tell; empty: they are not known
ViewShifts find_view_shifts(const std::vector<ViewPicture>& views,
                            const std::vector<VesselEnds>& ends = {});

}  // namespace angio::reconstruction::detail
