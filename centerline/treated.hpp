#pragma once

namespace angio::centerline {

/// The smallest healthy vessels that balloons are used in unasked [mm].
inline constexpr double kLeastTreated = 1.5;

}  // namespace angio::centerline
