// How fast a volume comes from the frames of a rotational run, and how much memory it takes: on two
// cores, and on the GPU where there is one.
//
//     reconstruction_speed [cpu] [gpu] [memory] [--folder DIR] [--markdown FILE]
//
// The run is made here, as balls in a body of water, and read as DICOM from DIR (default: the
// temporary folder; the GPU's takes 1.2 GB). Each time is the median of three.
#include <omp.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/texture_limit.hpp"
#include "core/parallel.hpp"
#include "datasets/rotational_run.hpp"
#include "pipeline/stages/loaded_frames.hpp"
#include "reconstruction/reconstruction.hpp"
#include "segmentation/read_run.hpp"
#include "testing/result_table.hpp"
#include "testing/temporary_folder.hpp"

namespace angio {
namespace {

namespace fs = std::filesystem;
using benchmarks::formatted;
using benchmarks::ResultTable;
using reconstruction::Reconstruction;
using reconstruction::ReconstructionOptions;

constexpr int kTimes = 3;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// What is measured of: frames of a size, over 200 degrees, and the voxels that are asked for.
struct Plan {
  int frames, columns, rows;
  double pixel_mm;  ///< at the isocentre
  int side;         ///< of a cube of as many voxels
};

struct Ball {
  Vec3 middle;
  double radius, attenuation;
};

/// A ball of water, and what looks like vessels in it.
std::vector<Ball> balls(double field_mm) {
  std::vector<Ball> all = {{{0, 0, 0}, 0.42 * field_mm, 0.0206}};
  for (int n = 0; n < 12; ++n) {
    const double angle = 0.9 * n;
    all.push_back({{0.25 * field_mm * std::cos(angle), 0.25 * field_mm * std::sin(angle),
                    field_mm * (0.02 * n - 0.12)},
                   0.012 * field_mm,
                   0.1});
  }
  return all;
}

/// The pixels of a frame, linear in the beam.
void project(const std::vector<Ball>& balls, const angiogram::ConeBeamFrame& frame,
             std::uint16_t* pixels) {
  constexpr double kAir = 40000.0;
  for (int row = 0; row < frame.rows; ++row)
    for (int column = 0; column < frame.columns; ++column) {
      const Vec3 ray = normalized(frame.place(column, row) - frame.source);
      double sum = 0.0;
      for (const Ball& ball : balls) {
        const Vec3 to = ball.middle - frame.source;
        const double along = dot(to, ray);
        const double left = ball.radius * ball.radius - (norm_squared(to) - along * along);
        if (left > 0.0) sum += 2.0 * ball.attenuation * std::sqrt(left);
      }
      *pixels++ = std::uint16_t(std::lround(kAir * std::exp(-sum)));
    }
}

fs::path write_run(const Plan& plan, const fs::path& folder) {
  datasets::RotationalRunOfPhantom made;
  made.phantom = datasets::make_phantom_surface({});
  angiogram::CArmMount& mount = made.mount;
  mount.columns = plan.columns;
  mount.rows = plan.rows;
  mount.column_spacing_mm = mount.row_spacing_mm =
      plan.pixel_mm * mount.source_to_detector_mm / mount.source_to_isocentre_mm;
  mount.central_column = 0.5 * (plan.columns - 1);
  mount.central_row = 0.5 * (plan.rows - 1);
  for (int f = 0; f < plan.frames; ++f) {
    made.primary_angles_degrees.push_back(-100.0 + 200.0 * f / (plan.frames - 1));
    made.frames.push_back(angiogram::c_arm_frame({made.primary_angles_degrees.back(), 0.0}, mount));
  }
  const std::size_t pixels = std::size_t(plan.columns) * std::size_t(plan.rows);
  made.pictures.resize(pixels * std::size_t(plan.frames));
  const std::vector<Ball> body = balls(plan.pixel_mm * std::min(plan.columns, plan.rows));
  parallel_for_uneven(plan.frames, [&](std::ptrdiff_t f) {
    project(body, made.frames[std::size_t(f)], made.pictures.data() + std::size_t(f) * pixels);
  });
  return datasets::write_rotational_run(made, {}, folder);
}

/// From the file to the volume, as `angio run` does it.
Reconstruction reconstruct(const fs::path& run_folder, const Plan& plan,
                           const ReconstructionOptions& options) {
  const auto loaded = segmentation::read_run(run_folder, {});
  angiogram::CArmMount mount;
  mount.source_to_detector_mm = loaded.value().run.source_to_detector_mm.value();
  mount.source_to_isocentre_mm = loaded->run.source_to_isocentre_mm.value();
  mount.columns = loaded->columns;
  mount.rows = loaded->rows;
  mount.column_spacing_mm = loaded->run.detector_spacing_mm[0];
  mount.row_spacing_mm = loaded->run.detector_spacing_mm[1];
  mount.central_column = 0.5 * (mount.columns - 1);
  mount.central_row = 0.5 * (mount.rows - 1);
  reconstruction::RotationalRun run;
  for (const double angle : loaded->run.primary_angles_degrees)
    run.frames.push_back(angiogram::c_arm_frame({angle, 0.0}, mount));
  const pipeline::LoadedFrames pictures(*loaded->pictures);
  run.pictures = &pictures;
  ReconstructionOptions sized = options;
  // As many voxels as a cube of that many, in the field that the frames see.
  sized.voxel_mm = 0.0;
  const auto& grid = reconstruction::forecast_run(run.frames, false, sized).grid;
  const double volume =
      grid.spacing.x * grid.spacing.y * grid.spacing.z * double(grid.voxel_count());
  sized.voxel_mm = std::cbrt(volume) / plan.side;
  return reconstruct_volume(run, sized);
}

std::string grid_of(const Reconstruction& result) {
  const auto& size = result.volume.geometry.size;
  return formatted("%d x %d x %d", size[0], size[1], size[2]);
}

double updates_of(const Reconstruction& result, int frames) {
  const auto& g = result.volume.geometry;
  const double radius = result.quality.field_radius_mm / g.spacing.x;
  return 3.141592653589793 * radius * radius * g.size[2] * frames;
}

struct Timed {
  Reconstruction last;
  double first = 0.0;                                     ///< [s]
  double whole = 0.0, filtering = 0.0, projecting = 0.0;  ///< medians [s]
};

Timed time(const std::function<Reconstruction()>& work) {
  Timed timed;
  std::vector<double> whole, filtering, projecting;
  for (int n = 0; n < kTimes; ++n) {
    timed.last = {};
    const double start = now();
    timed.last = work();
    whole.push_back(now() - start);
    filtering.push_back(timed.last.gpu.filtering);
    projecting.push_back(timed.last.gpu.projecting);
  }
  timed.first = whole.front();
  timed.whole = median(whole);
  timed.filtering = median(filtering);
  timed.projecting = median(projecting);
  return timed;
}

/// This thread and the others of its loops on the first cores that it may use, or on all of them.
void use_cores(int count) {
  cpu_set_t all, some;
  static const int most = omp_get_max_threads();
  static const cpu_set_t before = [] {
    cpu_set_t set;
    sched_getaffinity(0, sizeof set, &set);
    return set;
  }();
  all = before;
  CPU_ZERO(&some);
  for (int core = 0; core < CPU_SETSIZE && CPU_COUNT(&some) < count; ++core)
    if (CPU_ISSET(core, &all)) CPU_SET(core, &some);
  omp_set_num_threads(count > 0 ? count : most);
#pragma omp parallel
  sched_setaffinity(0, sizeof some, count > 0 ? &some : &all);
}

void measure_cpu(ResultTable& results, const fs::path& folder) {
  const Plan plan{133, 512, 512, 0.3, 256};
  const fs::path run = write_run(plan, folder / "small");
  use_cores(2);
  results.section("Two cores of the CPU");
  results.paragraph(
      "133 frames of 512 x 512 pixels (DICOM, uncompressed, in the system's cache) to a "
      "volume of as many voxels as 256 x 256 x 256 has, file to volume. Two threads on two "
      "cores. Bar: 8 s. The path of a C-arm that keeps to its header is judged by some "
      "frames, by default.");
  results.columns({"options", "voxels", "s", "10^9 updates/s, everything included"});
  for (const bool calibrate : {true, false}) {
    ReconstructionOptions options;
    options.backend = Backend::cpu;
    options.calibrate = calibrate;
    const Timed timed = time([&] { return reconstruct(run, plan, options); });
    results.row({calibrate ? "default" : "calibrate = false", grid_of(timed.last),
                 formatted("%.2f", timed.whole),
                 formatted("%.2f", updates_of(timed.last, plan.frames) / timed.whole * 1e-9)});
  }
  use_cores(0);
  fs::remove_all(folder / "small");
}

const Plan kLarge{496, 1248, 960, 0.2, 512};

/// @param start  what it took to start the GPU [s]
void measure_gpu(ResultTable& results, const fs::path& run, double start) {
  ReconstructionOptions options;
  options.backend = Backend::cuda;
  options.calibrate = false;
  const Timed plain = time([&] { return reconstruct(run, kLarge, options); });
  results.use_gpu(plain.last.device);
  options.calibrate = true;
  const Timed judged = time([&] { return reconstruct(run, kLarge, options); });
  const double kernels = plain.filtering + plain.projecting;
  const double updates = updates_of(plain.last, kLarge.frames);
  const double limit = benchmarks::texture_fetches_per_second();
  results.section("A GPU");
  results.paragraph("496 frames of 1248 x 960 pixels (RabbitCT's size) to " + grid_of(plain.last) +
                    " voxels. An update is a voxel within the field and a frame: one value of a "
                    "texture, linear between four samples. The limit is what a kernel gives that "
                    "does nothing but look up such values, from its caches "
                    "(`benchmarks/texture_limit.cu`).");
  results.columns({"what", "measured", "bar"});
  results.row({"kernels", formatted("%.3f s", kernels), "0.25 s"});
  results.row(
      {"of these: logarithm, plane, weights, filter", formatted("%.3f s", plain.filtering), ""});
  results.row({"of these: back-projection", formatted("%.3f s", plain.projecting), ""});
  results.row({"back-projection, updates a second",
               formatted("%.0f x 10^9", updates / plain.projecting * 1e-9), ""});
  results.row({"the same, all voxels counted as RabbitCT does",
               formatted("%.0f x 10^9", double(plain.last.volume.geometry.voxel_count()) *
                                            kLarge.frames / plain.projecting * 1e-9),
               ""});
  results.row({"the texture's limit", formatted("%.0f x 10^9", limit * 1e-9), ""});
  results.row(
      {"share of the limit", formatted("%.0f %%", 100.0 * updates / plain.projecting / limit), ""});
  results.row({"DICOM to volume, path not judged", formatted("%.2f s", plain.whole), "1.5 s"});
  results.row({"the same, the first of the three", formatted("%.2f s", plain.first), ""});
  results.row({"starting the GPU, once a process, beside these", formatted("%.2f s", start), ""});
  results.row({"DICOM to volume, default", formatted("%.2f s", judged.whole), "1.5 s"});
}

double status_mib(const char* key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == key) {
      double kibibytes = 0.0;
      status >> kibibytes;
      return kibibytes / 1024.0;
    }
  return 0.0;
}

void measure_memory(ResultTable& results, const fs::path& run, Backend backend) {
  ReconstructionOptions options;
  options.backend = backend;
  options.calibrate = false;
  std::vector<std::string> cells = {backend == Backend::cpu ? "CPU" : "GPU"};
  for (const bool calibrate : {false, true}) {
    options.calibrate = calibrate;
    std::ofstream("/proc/self/clear_refs") << "5";
    const double before = status_mib("VmRSS:");
    const double start = now();
    const Reconstruction result = reconstruct(run, kLarge, options);
    cells.push_back(formatted("%.2f GiB", (status_mib("VmHWM:") - before) / 1024.0));
    cells.push_back(formatted("%.1f s", now() - start));
  }
  results.row(cells);
}

}  // namespace

int measure(int argc, char** argv) {
  ResultTable results("Speed and memory of reconstruction", argc, argv);
  std::vector<std::string> parts;
  const test::TemporaryFolder temporary;
  fs::path folder = temporary.path();
  for (int n = 1; n < argc; ++n) {
    const std::string word = argv[n];
    if (word == "--folder" && n + 1 < argc)
      folder = argv[++n];
    else
      parts.push_back(word);
  }
  const auto wants = [&](const char* part) {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  const double before = now();
  const bool has_gpu = benchmarks::texture_fetches_per_second() > 0.0;
  const double start = now() - before;
  if (wants("cpu")) measure_cpu(results, folder);
  if (!(wants("gpu") && has_gpu) && !wants("memory")) {
    results.write();
    return 0;
  }
  const fs::path run = write_run(kLarge, folder / "large");
  if (wants("gpu") && has_gpu) measure_gpu(results, run, start);
  if (wants("memory")) {
    results.section("Memory");
    results.paragraph(
        "The same frames, 2.4 GB as numbers, to the same voxels, 0.5 GB: resident memory "
        "at its peak above that before. Bar: 4 GiB. Frames are read some at a time.");
    results.columns({"on", "path not judged", "time", "default", "time"});
    measure_memory(results, run, Backend::cpu);
    if (has_gpu) measure_memory(results, run, Backend::cuda);
  }
  fs::remove_all(folder / "large");
  results.write();
  return 0;
}

}  // namespace angio

int main(int argc, char** argv) {
  try {
    return angio::measure(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
