#include "pipeline/cli/doctor.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/sandbox.hpp"
#include "pipeline/version.hpp"
#include "simulation/simulation.hpp"
#include "viewer/view.hpp"

namespace angio::pipeline {
namespace {

/// A field of /proc/meminfo in GiB.
double memory_gib(const std::string& field) {
  std::ifstream file("/proc/meminfo");
  for (std::string word; file >> word;)
    if (word == field + ":") {
      double kibibytes = 0.0;
      file >> kibibytes;
      return kibibytes / (1024.0 * 1024.0);
    }
  return 0.0;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

/// First line of the NVIDIA driver's own version file; empty without a driver.
std::string gpu_driver() {
  std::ifstream file("/proc/driver/nvidia/version");
  std::string line;
  std::getline(file, line);
  return line;
}

}  // namespace

std::string examine_computer(bool as_json) {
  const viewer::DisplayStatus display = viewer::display_status();
  const std::string driver = gpu_driver();
  const simulation::CudaSupport cuda = simulation::cuda_support();
  const int threads = omp_get_max_threads();
  const SandboxSupport sandbox = sandbox_support();
  if (as_json)
    return nlohmann::json{
               {"version", kVersion},
               {"processor", processor_name()},
               {"threads", threads},
               {"memory_gib", memory_gib("MemTotal")},
               {"memory_available_gib", memory_gib("MemAvailable")},
               {"gpu_driver", driver.empty() ? nlohmann::json() : nlohmann::json(driver)},
               {"cuda_built", cuda.built},
               {"backend_used", cuda.device.empty() ? "cpu" : "cuda"},
               {"window", display.window},
               {"offscreen", display.offscreen},
               {"display", display.description},
               {"landlock", sandbox.landlock_version},
               {"seccomp", sandbox.system_calls}}
               .dump(2) +
           "\n";
  std::string text = fmt::format("angio {}\n", version_with_commit());
  const auto line = [&](const char* what, const std::string& found) {
    text += fmt::format("{:<12} {}\n", what, found);
  };
  line("processor", fmt::format("{}, {} threads will be used", processor_name(), threads));
  line("memory", fmt::format("{:.1f} GiB, {:.1f} GiB free", memory_gib("MemTotal"),
                             memory_gib("MemAvailable")));
  line("GPU", driver.empty() ? "no NVIDIA driver found" : driver);
  line("backend", !cuda.built           ? "cpu will be used (this program was built without CUDA)"
                  : cuda.device.empty() ? "cpu will be used (no GPU that CUDA can use)"
                                        : "cuda will be used, on " + cuda.device);
  line("sandbox", to_text(sandbox));
  line("display", display.description);
  line("pictures", display.offscreen ? "can be made"
                                     : "cannot be made: install the package xvfb, or set DISPLAY");
  return text;
}

}  // namespace angio::pipeline
