#pragma once

#include "testing/simulation/models.hpp"

namespace angio::simulation::testing {

/// A short stenosed tube whose whole dilation takes seconds; for tests and benchmarks.
inline StenosedTube small_stenosis() {
  StenosedTube p;
  p.length = 18.0;
  p.lesion_length = 6.0;
  p.balloon_length = 9.0;
  p.balloon_rings = 20;
  p.balloon_around = 16;
  p.wall_rings = 45;
  p.wall_around = 20;
  return p;
}

}  // namespace angio::simulation::testing
