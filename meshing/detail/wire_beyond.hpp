#pragma once

#include "core/centerline.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing::detail {

/// How far the guidewire is drawn on each side of the balloon [mm]. A real one runs on for 1.5 m
/// towards the hand and for the 30 mm of its floppy tip; so much shows where it lies in the vessel.
inline constexpr double kWireBeyond = 10.0;

/// Draws the guidewire on along the path beyond the balloon, in the balloon's spacing, to
/// kWireBeyond or the path's end: from the pole in the wire's direction there, and over the width
/// of the vessel onto the smoothed path,
///
///     x(s) = p(s) + h00(u) (x_pole - p(0)) + w h10(u) (t_pole - p'(0)),   u = s / w <= 1
///
/// with the cubic Hermite polynomials that are 1 and 0, and have the slopes 0 and 1, at u = 0.
///
/// @param sigma  of the path's smoothing [mm], > 0
void extend_wire(const CenterlinePath& path, double sigma, Balloon& balloon);

}  // namespace angio::meshing::detail
