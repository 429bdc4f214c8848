#pragma once

#include <vector>

#include "core/volume.hpp"
#include "reconstruction/reconstruction.hpp"

/// The C-arm's real path, from the vessels themselves: each frame is moved until it sees them where
/// the volume has them.
namespace angio::reconstruction::detail {

/// A small part of what stands out of its surroundings.
struct BrightPoint {
  Vec3 point;           ///< LPS [mm]
  double amount = 0.0;  ///< attenuation above its surroundings times volume [mm^2]
};

/// The voxels that stand out most of what lies around them, within a few mm: vessels and edges of
/// bone.
/// @return none where nothing stands out of the noise
std::vector<BrightPoint> find_bright_points(const Volume<float>& volume, double noise_per_mm);

/// How the C-arm stands beside where a frame's header has it: source and detector as one, turned
/// around the origin and shifted.
struct Motion {
  Vec3 turn;   ///< axis times angle [radians], small
  Vec3 shift;  ///< [mm]
};
angiogram::ConeBeamFrame moved(angiogram::ConeBeamFrame frame, const Motion& motion);

struct FrameFit {
  Motion motion;              ///< from the frame as given
  double moved_pixels = 0.0;  ///< of the points in the picture by this fit, root mean square
  bool is_fitted = false;     ///< the frame sees enough of the points
};

/// Moves a frame so that it sees the points where they are in its picture: by Gauss-Newton on
///
///     min over w, t, s:  sum over pixels (p - b - s sum_j m_j g(pixel - see(x_j)))^2 / sigma^2
///                        + |w|^2 / sd_w^2 + |t|^2 / sd_t^2
///
/// p: line integrals; b: p around the points, smoothed; g: a Gaussian of about a pixel; w, t: turn
/// and shift; s: how much contrast medium the frame sees against the mean.
///
/// @param line_integrals  shape [rows, columns]
/// @param blur_pixels     sd of g, > 0.5
/// @param given  the frame as its header has it
/// @param from   where to begin
FrameFit fit_frame(const angiogram::ConeBeamFrame& given, const Motion& from,
                   const std::vector<float>& line_integrals, const std::vector<BrightPoint>& points,
                   double blur_pixels);

/// Takes out what all frames have in common: a motion of everything is no motion.
void take_out_common(std::vector<Motion>& motions);

}  // namespace angio::reconstruction::detail
