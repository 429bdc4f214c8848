#pragma once

#include <cstdint>
#include <string>

namespace angio::segmentation::detail {

/// @param needed_bytes    what reading takes at the most
/// @param max_memory_gib  the user's own limit; 0: none
/// @throws InputError naming need and limit, if the need is greater
void check_memory(std::uint64_t needed_bytes, double max_memory_gib, const std::string& what);

}  // namespace angio::segmentation::detail
