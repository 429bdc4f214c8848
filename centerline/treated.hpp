#pragma once

namespace angio::centerline {

/// The smallest healthy vessels that balloons are used in unasked [mm].
inline constexpr double kLeastTreated = 1.5;
/// Where the lumen is wider than this share of the healthy vessel, a balloon that fits the vessel
/// touches nothing.
inline constexpr double kWidestTried = 1.25;

}  // namespace angio::centerline
