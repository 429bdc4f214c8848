#pragma once

namespace angio {

/// Where a stage computes (`--backend`): `automatic` takes the GPU if there is one, and the CPU,
/// with a warning, if it fails.
enum class Backend { automatic, cpu, cuda };

}  // namespace angio
