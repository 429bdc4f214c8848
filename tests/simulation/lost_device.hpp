#pragma once

namespace angio::simulation::testing {

/// Traps in a kernel, after which CUDA refuses all work to this process.
void lose_device();

}  // namespace angio::simulation::testing
