#include "segmentation/detail/available_memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "core/error.hpp"
#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kGibibyte = 1024.0 * 1024.0 * 1024.0;
constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

std::uint64_t number_in(const char* path) {
  std::uint64_t value = kNoLimit;  // "max" reads as no number
  std::ifstream file(path);
  return file >> value ? value : kNoLimit;
}

std::uint64_t free_in_computer() {
  std::ifstream file("/proc/meminfo");
  std::string name;
  std::uint64_t kibibytes = 0;
  std::string unit;
  while (file >> name >> kibibytes) {
    if (name == "MemAvailable:") return kibibytes * 1024;
    std::getline(file, unit);
  }
  return kNoLimit;
}

/// File pages that the group is charged for but gives back when memory is asked for.
std::uint64_t cached_in_group() {
  std::ifstream file("/sys/fs/cgroup/memory.stat");
  std::string name;
  std::uint64_t bytes = 0;
  while (file >> name >> bytes)
    if (name == "inactive_file") return bytes;
  return 0;
}

std::uint64_t free_in_group() {
  const std::uint64_t most = number_in("/sys/fs/cgroup/memory.max");
  std::uint64_t used = number_in("/sys/fs/cgroup/memory.current");
  if (used != kNoLimit) used -= std::min(used, cached_in_group());
  return most == kNoLimit || used == kNoLimit ? kNoLimit : most - std::min(most, used);
}

std::uint64_t free_in_address_space() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kNoLimit;
  const std::uint64_t pages = number_in("/proc/self/statm");
  const std::uint64_t used = pages * std::uint64_t(sysconf(_SC_PAGESIZE));
  return limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, used);
}

}  // namespace

std::uint64_t available_memory_bytes() {
  return std::min({free_in_computer(), free_in_group(), free_in_address_space()});
}

void check_memory(std::uint64_t needed_bytes, double max_memory_gib, const std::string& what) {
  const double needed = double(needed_bytes) / kGibibyte;
  const double available = double(available_memory_bytes()) / kGibibyte;
  const bool is_own_limit = max_memory_gib > 0.0 && max_memory_gib < available;
  const double limit = is_own_limit ? max_memory_gib : available;
  if (needed <= limit) return;
  throw InputError("reading " + what + " needs " + format_number(needed) + " GiB of memory, but " +
                   format_number(limit) + " GiB " +
                   (is_own_limit ? "are allowed (raise the limit, or crop the series)"
                                 : "are free (crop the series, or close programs)"));
}

}  // namespace angio::segmentation::detail
