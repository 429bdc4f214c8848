#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <string>

#include "benchmarks/contact_rows.hpp"
#include "testing/simulation/small_stenosis.hpp"

namespace angio::simulation {
namespace {

constexpr double kMegabyte = 1048576.0;

struct Memory {
  double allocated = 0.0, resident = 0.0;  ///< [MB]
};

// What is freed, but kept for the next allocation, is given back first: how much that is changes
// from run to run.
Memory memory_now() {
  malloc_trim(0);
  const struct mallinfo2 heap = mallinfo2();
  long pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return {double(heap.uordblks + heap.hblkhd) / kMegabyte,
          double(resident) * double(sysconf(_SC_PAGESIZE)) / kMegabyte};
}

// FNV-1a over the bytes of all frames.
std::size_t fingerprint(const SimulationModel& model, const SimulationOptions& options) {
  std::size_t hash = 1469598103934665603ULL;
  const auto add = [&](const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211ULL;
  };
  simulate(model, options, [&](const SimulationFrame& f) {
    add(f.balloon.data(), f.balloon.size() * sizeof(Vec3));
    add(f.wall.data(), f.wall.size() * sizeof(Vec3));
    add(&f.contact.viscous_delta_mm, sizeof(double));
  });
  return hash;
}

}  // namespace

Rows soak(int count) {
  testing::StenosedTube p = testing::small_stenosis();
  p.balloon_rings = 13;
  p.balloon_around = 12;
  p.wall_rings = 31;
  p.wall_around = 14;
  const SimulationModel model = testing::make_model(p);
  SimulationOptions options = schedule();
  options.inflation.inflate_s = 0.3;
  options.inflation.hold_s = options.inflation.rest_s = 0.025;
  options.inflation.deflate_s = 0.2;
  const std::size_t first = fingerprint(model, options);
  Memory before;
  int different = 0;
  for (int i = 1; i < count; ++i) {
    different += fingerprint(model, options) == first ? 0 : 1;
    if (i == std::min(10, count / 2)) before = memory_now();
  }
  const Memory after = memory_now();
  const std::string name = "soak, " + std::to_string(count) + " inflations: ";
  return {{name + "runs with other bytes", double(different), 0.0, ""},
          {name + "growth of allocated memory after the first ones",
           after.allocated - before.allocated, 0.01, "MB"},
          {name + "growth of resident memory after the first ones",
           after.resident - before.resident, 1.0, "MB"}};
}

}  // namespace angio::simulation
