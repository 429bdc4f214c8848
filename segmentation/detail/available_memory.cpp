#include "segmentation/detail/available_memory.hpp"

#include "core/available_memory.hpp"
#include "core/error.hpp"
#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {

void check_memory(std::uint64_t needed_bytes, double max_memory_gib, const std::string& what) {
  const double needed = double(needed_bytes) / kBytesPerGibibyte;
  const double available = double(available_memory_bytes()) / kBytesPerGibibyte;
  const bool is_own_limit = max_memory_gib > 0.0 && max_memory_gib < available;
  const double limit = is_own_limit ? max_memory_gib : available;
  if (needed <= limit) return;
  throw InputError("reading " + what + " needs " + format_number(needed) + " GiB of memory, but " +
                   format_number(limit) + " GiB " +
                   (is_own_limit ? "are allowed (raise the limit, or crop the series)"
                                 : "are free (crop the series, or close programs)"));
}

}  // namespace angio::segmentation::detail
