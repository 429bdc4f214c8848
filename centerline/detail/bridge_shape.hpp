#pragma once

#include "core/units.hpp"

/// What tells a bridge between two vessels that touch from a stenosis in a bend.
namespace angio::centerline {

/// A bridge is no longer than from the one vessel's axis over their walls to the other's: in
/// diameters.
inline constexpr double kBridgeFromAxisToAxis = 1.25;
/// A line turns by more than this around a bridge, into it and out of it [rad].
inline constexpr double kBridgeTurning = 80.0 / 180.0 * units::kPi;
/// And by more than this on either side of it [rad].
inline constexpr double kBridgeLeastTurn = 25.0 / 180.0 * units::kPi;

}  // namespace angio::centerline
