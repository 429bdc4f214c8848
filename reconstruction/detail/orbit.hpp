#pragma once

#include <vector>

#include "angiogram/cone_beam.hpp"

namespace angio::reconstruction::detail {

/// The circle that a run's source goes along, and where on it each frame stands.
struct Orbit {
  Vec3 isocentre;                          ///< on the axis, where the frames look [mm]
  Vec3 axis;                               ///< unit
  Vec3 first_direction, second_direction;  ///< unit, across the axis: angle 0 and 90 degrees

  // Of each frame, shape [frame_count].
  std::vector<double> angle;   ///< of its source [radians], without jumps of a turn
  std::vector<double> radius;  ///< the source's distance from the axis [mm]
  std::vector<double> height;  ///< the source's, along the axis from the isocentre [mm]
  std::vector<double> step;    ///< of arc that it stands for [radians]

  double first_angle = 0.0, last_angle = 0.0;  ///< half a step beyond the outermost frames
  double largest_step = 0.0;                   ///< between neighbours [radians]

  [[nodiscard]] double arc() const { return last_angle - first_angle; }
  /// Towards the source from the axis, and to its right as seen from above (axis x to_source).
  [[nodiscard]] Vec3 to_source(std::size_t frame) const;
  [[nodiscard]] Vec3 across(std::size_t frame) const;
};

/// Fits the axis (the normal of the plane through the sources; an axis of the patient that it
/// differs from by less than two degrees), then the circle (Kasa, IEEE Trans. Instrum. Meas. 25:8,
/// 1976).
/// @throws InputError  fewer than 3 frames, a still source, or an arc under 40 degrees
Orbit fit_orbit(const std::vector<angiogram::ConeBeamFrame>& frames);

}  // namespace angio::reconstruction::detail
