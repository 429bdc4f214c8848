#pragma once

#include "centerline/centerline.hpp"

namespace angio::centerline {

/// A profile without single sections that took something else for their wall: a ball of radius r,
/// x along the line from here, holds one of r - x, and these are narrower than both neighbours
/// prove.
LumenProfile without_disproved(const LumenProfile& seen);

}  // namespace angio::centerline
