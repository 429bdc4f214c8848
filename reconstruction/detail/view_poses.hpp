#pragma once

#include <vector>

#include "core/centerline.hpp"
#include "core/vec3.hpp"
#include "reconstruction/detail/view_picture.hpp"

namespace angio::reconstruction::detail {

/// Where a view's C-arm stands against where it says: turned around the isocentre, then shifted.
struct ViewPose {
  Vec3 turn;   ///< its axis, as long as its angle [radians]
  Vec3 shift;  ///< [mm]
};

/// How far C-arms stand from where they say: tables move by centimetres between runs, and angles
/// are told to about a degree.
struct PosePrior {
  double shift_sd_mm = 10.0;
  double turn_sd_degrees = 1.0;
};

/// Where a place of a C-arm that stands as it says is in one that does not; the same of its frame.
Vec3 posed(const Vec3& place, const ViewPose& pose);
angiogram::ConeBeamFrame posed(angiogram::ConeBeamFrame frame, const ViewPose& pose);

/// Poses under which the views see a tree's places on their lines (bundle adjustment; Triggs et
/// al., Vision Algorithms 1999, p. 298, each place eliminated):
///
///     min  sum over places x, views v that see a line near   rho(n . (see_v(x) - q) / 1 pixel)
///          + sum over views but the first  |turn|^2 / sd_t^2 + |shift|^2 / sd_s^2
///
/// q: the nearest pixel of the view's line, n: across the line there; rho: Huber's. Lines are known
/// to about a pixel. Places move, too, so that those that two views alone see tell nothing of the
/// poses: some place lies on both their lines wherever the C-arms stand. Of two views all poses
/// are none.
///
/// @param views  at least one, as they say they were taken
/// @param tree   as they see it from the poses `start`
/// @param start  shape [views]; the first one's is none, and stays
std::vector<ViewPose> find_view_poses(std::vector<ViewPicture> views, const CenterlineTree& tree,
                                      std::vector<ViewPose> start, const PosePrior& prior = {});

}  // namespace angio::reconstruction::detail
