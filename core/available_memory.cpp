#include "core/available_memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

namespace angio {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

std::uint64_t number_in(const fs::path& path) {
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

/// Where the kernel keeps the groups, and how it names their files.
struct GroupFiles {
  const char* root;
  const char* most;
  const char* used;
  const char* cached;  ///< in memory.stat: given back when memory is asked for
};
constexpr GroupFiles kVersion1 = {"/sys/fs/cgroup/memory", "memory.limit_in_bytes",
                                  "memory.usage_in_bytes", "total_inactive_file"};
constexpr GroupFiles kVersion2 = {"/sys/fs/cgroup", "memory.max", "memory.current",
                                  "inactive_file"};

std::uint64_t cached_in(const fs::path& group, const GroupFiles& files) {
  std::ifstream file(group / "memory.stat");
  std::string name;
  std::uint64_t bytes = 0;
  while (file >> name >> bytes)
    if (name == files.cached) return bytes;
  return 0;
}

std::uint64_t free_in(const fs::path& group, const GroupFiles& files) {
  const std::uint64_t most = number_in(group / files.most);
  std::uint64_t used = number_in(group / files.used);
  if (used != kNoLimit) used -= std::min(used, cached_in(group, files));
  return most == kNoLimit || used == kNoLimit ? kNoLimit : most - std::min(most, used);
}

/// The least of a group and those that it is in. A container's own view begins at its group.
std::uint64_t free_in_groups(fs::path group, const GroupFiles& files) {
  std::uint64_t least = free_in(files.root, files);
  for (; group.has_relative_path(); group = group.parent_path())
    least = std::min(least, free_in(files.root / group.relative_path(), files));
  return least;
}

std::uint64_t free_in_control_groups() {
  std::uint64_t least = kNoLimit;
  std::ifstream file("/proc/self/cgroup");  // number:controllers:/path
  for (std::string line; std::getline(file, line);) {
    const auto path = line.find('/');
    if (path == std::string::npos) continue;
    if (line.starts_with("0::"))
      least = std::min(least, free_in_groups(line.substr(path), kVersion2));
    else if (line.find(":memory:") != std::string::npos)
      least = std::min(least, free_in_groups(line.substr(path), kVersion1));
  }
  return least;
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
  return std::min({free_in_computer(), free_in_control_groups(), free_in_address_space()});
}

}  // namespace angio
