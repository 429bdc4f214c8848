#pragma once

#include "segmentation/read_volume.hpp"

namespace angio::segmentation::detail {

/// Reads a run's increments as cumulative if asked to, and notes what makes its angles doubtful:
/// another number of angles than frames, a turn of more than 360 degrees, turning back and forth,
/// uneven steps, or increments that are all alike.
///
///     from the base:  angle_i = base + increment_i          cumulative:  angle_i = angle_(i-1) +
///     increment_i
///
/// Source: DICOM PS3.3 C.8.7.5.1.3 (a base of 0 makes the increments absolute angles).
void settle_angles(ProjectionRun& run, int frame_count, AngleIncrements increments);

}  // namespace angio::segmentation::detail
