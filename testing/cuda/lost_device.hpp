#pragma once

namespace angio::testing {

/// Traps in a kernel, after which CUDA refuses all work to this process.
void lose_device();

}  // namespace angio::testing
