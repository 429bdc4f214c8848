#pragma once

#include <cstdint>

namespace angio {

inline constexpr double kBytesPerGibibyte = 1024.0 * 1024.0 * 1024.0;

/// What this process can still take [bytes]: the computer's free memory, the limits of its control
/// group (a container's, a cluster's; version 1 or 2) and of those around it, and the limit of its
/// address space, whichever is least.
std::uint64_t available_memory_bytes();

}  // namespace angio
