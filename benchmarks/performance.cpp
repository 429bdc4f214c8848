#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/performance_parts.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/cloth.hpp"
#include "simulation/pbd/membrane_solver.hpp"
#include "simulation/pbd/sheet_solver.hpp"
#include "simulation/run/balloon_section.hpp"
#include "simulation/run/measure.hpp"
#include "testing/result_table.hpp"
#include "testing/simulation/layered.hpp"
#include "testing/simulation/matched.hpp"
#include "testing/simulation/small_stenosis.hpp"

/// Prints how fast the solver is, on the CPU and on a GPU if there is one; docs/performance.md
/// explains the tables. Needs the simulation library alone.
///
///     performance [free|size|compare|wall|layered|paper|air|cloth|check ...] [--markdown FILE]
///
/// Without a word all but `check`, which is for tools that watch a program's memory.
namespace angio::simulation {

using namespace detail;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

const std::string& gpu_name() {
  static const std::string kName = []() -> std::string {
    try {
      SimulationModel model;
      model.balloon = testing::closed_tube(2.0, 5, 6, [](double) { return 0.5; });
      model.balloon_rest = model.balloon.vertices;
      model.balloon_fixed.assign(model.balloon.vertices.size(), 0);
      const Scene scene = make_scene(model, {});
      return make_cuda_solver(scene, {})->device();
    } catch (const Error& error) {
      std::fprintf(stderr, "no GPU: %s\n", error.what());
      return {};
    }
  }();
  return kName;
}

std::string backend_name(int threads) {
  return threads == 0 ? "CUDA" : formatted("CPU, %d thread%s", threads, threads == 1 ? "" : "s");
}

SimulationModel paper_balloon(int rings, int around) {
  SimulationModel model;
  model.balloon = testing::closed_tube(10.0, rings, around, [](double) { return 0.5; });
  model.balloon_rest = model.balloon.vertices;
  model.balloon_fixed.assign(model.balloon.vertices.size(), 0);
  model.measure_point = {0, 0, 1e-3};
  model.measure_tangent = {0, 0, 1};
  return model;
}

SimulationOptions ramp() {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.balloon.wall_mm = 0.04;
  options.inflation.control = InflationControl::pressure;
  options.inflation.peak_pressure_atm = units::atm_from_pascal(0.48e6);
  options.inflation.inflate_s = 2.5;
  options.inflation.hold_s = 0.5;
  options.inflation.deflate_s = 0.025;
  options.inflation.rest_s = 0.0;
  return options;
}

namespace {

struct Course {
  double seconds = 0.0;
  int frames = 0;
  long sweeps = 0;
  double worst_residual = 0.0;
  std::vector<double> diameter;
  std::vector<std::vector<Vec3>> x;
};

Course go(const Scene& scene, const SimulationModel& model, const SimulationOptions& options,
          StepSolver& solver, int loaded_frames = 120) {
  Course course;
  const double volume = balloon_volume(scene, scene.start);
  const Control control = make_control(scene, options, volume);
  std::vector<State> states;
  const double begin = now();
  solver.run(control, [&](int frame, const State& state) {
    if (frame == 0 || frame > loaded_frames) return;
    ++course.frames;
    course.sweeps += state.report.sweeps;
    course.worst_residual = std::max(course.worst_residual, state.report.residual);
    states.push_back(state);
  });
  course.seconds = (now() - begin) * course.frames / double(control.inflator.frame_count() - 1);
  for (State& state : states) {
    course.diameter.push_back(diameter_across(scene.balloon.triangles, state.x, model.measure_point,
                                              normalized(model.measure_tangent)));
    course.x.push_back(std::move(state.x));
  }
  return course;
}

double worst_lag(const Course& course, const Course& exact) {
  double worst = 0.0;
  for (std::size_t i = 0; i < course.diameter.size(); ++i)
    worst = std::max(worst, std::abs(course.diameter[i] / exact.diameter[i] - 1.0));
  return worst;
}

Course best_of(int rounds, const Scene& scene, const SimulationModel& model,
               const SimulationOptions& options, bool gpu, Precision precision, int threads) {
  Course best;
  for (int round = 0; round < rounds; ++round) {
    const auto solver = gpu ? make_cuda_solver(scene, options, precision)
                            : make_cpu_solver(scene, options, precision, threads);
    Course course = go(scene, model, options, *solver);
    if (round == 0 || course.seconds < best.seconds) best = std::move(course);
  }
  return best;
}

void free_balloon(ResultTable& results) {
  const SimulationModel model = paper_balloon();
  SimulationOptions options = ramp(), tight = ramp();
  tight.tolerance = 1e-5;
  tight.sweeps = 300;
  const Scene scene = make_scene(model, options);
  const Course exact = best_of(1, scene, model, tight, false, Precision::double_, 0);
  results.section("The paper's balloon, free");
  results.paragraph(formatted("%d vertices, %zu triangles, %zu colours: 0 to 0.48 MPa.",
                              scene.bodies.balloon().count, scene.balloon.triangles.size(),
                              scene.balloon.color_begin.size() - 1));
  if (has_gpu()) {
    options.tolerance = 0.005;
    for (const Spread spread : {Spread::block, Spread::grid}) {
      const auto solver = make_cuda_solver(scene, options, Precision::single, spread);
      const Course c = go(scene, model, options, *solver);
      results.paragraph(formatted("CUDA, %s: %.0f frames/s.",
                                  spread == Spread::block ? "one block" : "a grid",
                                  c.frames / c.seconds));
    }
  }
  results.columns({"backend", "precision", "tolerance", "frames/s", "sweeps a frame", "us a sweep",
                   "worst lag of the diameter %"});
  for (const double tolerance : {0.02, 0.005, 0.001})
    for (const Precision precision : {Precision::single, Precision::double_})
      for (const int threads : {1, 2, 0}) {
        const bool gpu = threads == 0;
        if (gpu && !has_gpu()) continue;
        if (tolerance != 0.005 && threads == 1) continue;
        options.tolerance = tolerance;
        const Course c = best_of(gpu ? 5 : 3, scene, model, options, gpu, precision, threads);
        results.row({backend_name(gpu ? 0 : threads),
                     precision == Precision::single ? "float" : "double",
                     formatted("%g", tolerance), formatted("%.0f", c.frames / c.seconds),
                     formatted("%.1f", double(c.sweeps) / c.frames),
                     formatted("%.2f", 1e6 * c.seconds / double(c.sweeps)),
                     formatted("%.3f", 100.0 * worst_lag(c, exact))});
      }
}

// Bytes that a sweep must move at least: each corner's constants once, each vertex's state once.
double bytes_per_sweep(const Scene& scene, std::size_t real) {
  const double corner = double(sizeof(CornerLink) + 7 * real);
  const double vertex = double(2 * 3 * real + 3 * real + real + sizeof(int) + 2 * 11 * real);
  return corner * double(scene.balloon.corners.size()) + vertex * scene.bodies.balloon().count;
}

double seconds_per_sweep(StepSolver& solver, const SimulationOptions& options, int sweeps) {
  GasLaw<double> law;
  law.limit = law.top = 1e30;
  law.slope_pressure = outside_pressure(options) + 0.2e6;
  double best = 1e30;
  for (int round = 0; round < 3; ++round) {
    double begin = now();
    solver.settle(law, 1e-30, 1);
    const double one = now() - begin;
    begin = now();
    solver.settle(law, 1e-30, 1 + sweeps);
    best = std::min(best, (now() - begin - one) / sweeps);
  }
  return best;
}

void sizes(ResultTable& results) {
  results.section("Cost of a sweep against size, single precision");
  results.columns({"triangles", "vertices", "colours", "backend", "us a sweep", "ns a triangle",
                   "MB a sweep", "GB/s"});
  for (const int scale : {1, 2, 4, 8, 16, 22}) {
    const SimulationModel model = paper_balloon(26 * scale, 20 * scale);
    const SimulationOptions options = ramp();
    const Scene scene = make_scene(model, options);
    const double bytes = bytes_per_sweep(scene, sizeof(float));
    for (const int way : {0, 1, 2}) {
      const bool gpu = way > 0;
      if ((gpu && !has_gpu()) || (way == 1 && scale > 2)) continue;
      const auto solver = gpu ? make_cuda_solver(scene, options, Precision::single,
                                                 way == 1 ? Spread::block : Spread::grid)
                              : make_cpu_solver(scene, options, Precision::single, 2);
      const int sweeps = std::max(5, gpu ? 400 / scale : 60 / (scale * scale));
      const double seconds = seconds_per_sweep(*solver, options, sweeps);
      results.row({std::to_string(scene.balloon.triangles.size()),
                   std::to_string(scene.bodies.balloon().count),
                   std::to_string(scene.balloon.color_begin.size() - 1),
                   way == 0   ? "CPU, 2 threads"
                   : way == 1 ? "CUDA, one block"
                              : "CUDA, a grid",
                   formatted("%.1f", 1e6 * seconds),
                   formatted("%.2f", 1e9 * seconds / double(scene.balloon.triangles.size())),
                   formatted("%.3f", 1e-6 * bytes), formatted("%.1f", 1e-9 * bytes / seconds)});
    }
  }
}

// Seconds of a step, median of 51 of 25 ms in which the corners are pulled apart by 35 %.
template <class Solver>
double cloth_step(const ClothOptions& options, const std::function<void(Solver&)>& step) {
  constexpr int kSteps = 51;
  const TriangleMesh rest = cloth_mesh(options);
  const auto row = std::size_t(options.cells) + 1;
  const std::size_t corners[] = {0, row - 1, row * (row - 1), row * row - 1};
  std::vector<char> fixed(rest.vertices.size(), 0);
  for (const std::size_t c : corners) fixed[c] = 1;
  Solver solver(rest, {1.031e6, 3.69e6}, options.thickness_mm, 1.07e-3, fixed);
  const Vec3 centre{0.5 * options.side_mm, 0.5 * options.side_mm, 0.0};
  std::vector<double> seconds;
  for (int i = 1; i <= kSteps; ++i) {
    const double stretch = 1.0 + options.stretch * i / kSteps;
    for (const std::size_t c : corners)
      solver.set_position(int(c), centre + stretch * (rest.vertices[c] - centre));
    const double begin = now();
    step(solver);
    seconds.push_back(now() - begin);
  }
  std::nth_element(seconds.begin(), seconds.begin() + kSteps / 2, seconds.end());
  return seconds[kSteps / 2];
}

void cloth(ResultTable& results) {
  ClothOptions options;
  results.section("The cloth, steps of 20 iterations, one core, median of 51 [ms]");
  results.columns({"triangles", "vertices", "paper", "vbd, widest packs", "vbd, 8 lanes"});
  for (const int cells : {50, 100, 200}) {
    options.cells = cells;
    const double paper = cloth_step<PbdSolver>(options, [](PbdSolver& s) { s.step({}, {}); });
    double vbd[2];
    for (const int lanes : {8, 0})
      vbd[lanes / 8] = cloth_step<SheetSolver>(options, [&](SheetSolver& s) {
        SheetStep step;
        step.lanes = lanes;
        s.step(step);
      });
    results.row({std::to_string(2 * cells * cells), std::to_string((cells + 1) * (cells + 1)),
                 formatted("%.2f", 1e3 * paper), formatted("%.2f", 1e3 * vbd[0]),
                 formatted("%.2f", 1e3 * vbd[1])});
  }
}

}  // namespace
}  // namespace angio::simulation

int main(int argc, char** argv) try {
  using namespace angio::simulation;
  angio::benchmarks::ResultTable results("Speed of the simulation", argc, argv);
  struct Part {
    std::string name;
    void (*run)(ResultTable&);
  };
  const std::vector<Part> parts{
      {"free", free_balloon},     {"size", sizes},  {"compare", compare}, {"wall", angioplasty},
      {"layered", layered_walls}, {"paper", paper}, {"air", air_mesh},    {"cloth", cloth}};
  const std::vector<std::string> asked(argv + 1, argv + argc);
  for (const std::string& word : asked)
    if (word != "check" && std::none_of(parts.begin(), parts.end(),
                                        [&](const Part& part) { return part.name == word; })) {
      std::fprintf(stderr,
                   "usage: performance [free|size|compare|wall|layered|paper|air|cloth|check ...] "
                   "[--markdown FILE]\n");
      return 64;
    }
  const auto is_asked = [&](const std::string& name) {
    return asked.empty() || std::find(asked.begin(), asked.end(), name) != asked.end();
  };
  if (!asked.empty() && is_asked("check")) check();
  if (has_gpu()) results.use_gpu(gpu_name());
  for (const Part& part : parts)
    if (is_asked(part.name)) part.run(results);
  results.write();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "performance: %s\n", error.what());
  return 70;
}
