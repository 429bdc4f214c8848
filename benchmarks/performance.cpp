#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/result_table.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/cloth.hpp"
#include "simulation/pbd/membrane_solver.hpp"
#include "simulation/pbd/sheet_solver.hpp"
#include "simulation/run/balloon_section.hpp"
#include "simulation/run/measure.hpp"
#include "tests/simulation/layered.hpp"
#include "tests/simulation/matched.hpp"
#include "tests/simulation/small_stenosis.hpp"

/// Prints how fast the solver is, on the CPU and on a GPU if there is one; docs/performance.md
/// explains the tables. Needs the simulation library alone.
///
///     performance [free|size|compare|wall|layered|paper|air|cloth|check ...] [--markdown FILE]
///
/// Without a word all but `check`, which is for tools that watch a program's memory.
namespace angio::simulation {
namespace {

using namespace detail;
using benchmarks::formatted;
using benchmarks::ResultTable;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The GPU's name; empty if there is none.
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

bool has_gpu() { return !gpu_name().empty(); }

/// @param threads  0 for a GPU
std::string backend_name(int threads) {
  return threads == 0 ? "CUDA" : formatted("CPU, %d thread%s", threads, threads == 1 ? "" : "s");
}

// The seed paper's balloon (Table 2) of its rubber, 0.5 mm x 10 mm, by rings and vertices around.
SimulationModel paper_balloon(int rings = 26, int around = 20) {
  SimulationModel model;
  model.balloon = testing::closed_tube(10.0, rings, around, [](double) { return 0.5; });
  model.balloon_rest = model.balloon.vertices;
  model.balloon_fixed.assign(model.balloon.vertices.size(), 0);
  model.measure_point = {0, 0, 1e-3};
  model.measure_tangent = {0, 0, 1};
  return model;
}

// 0 to 0.48 MPa in 100 frames of 25 ms, to a hoop stretch of about 1.3, held for 20.
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

// A course with a wall: the tubes of the seed paper's vessels, by their number of vertices.
struct WallCase {
  const char* name;
  int rings, around;
  bool folded;
};

// The paper's rubber balloon, blown up unfolded, or a wrapped balloon of PA-12.
SimulationModel wall_model(const WallCase& c, SimulationOptions& options) {
  testing::StenosedTube p;
  p.wall_rings = c.rings;
  p.wall_around = c.around;
  SimulationModel model = testing::make_model(p);
  if (c.folded) return model;
  model.balloon_rest = model.balloon.vertices;
  options.balloon.name = "polyurethane";
  options.inflation.peak_pressure_atm = 7.0;
  return model;
}

void print_split(const WallCase& c, const SimulationModel& model, const SimulationOptions& options,
                 bool gpu, int threads, ResultTable& results) {
  const Scene scene = make_scene(model, options);
  const double volume = balloon_volume(scene, scene.start);
  TriangleMesh rest = model.balloon;
  rest.vertices = model.balloon_rest;
  const Control control = make_control(scene, options, std::max(volume, enclosed_volume(rest)));
  const auto solver = gpu ? make_cuda_solver(scene, options)
                          : make_cpu_solver(scene, options, Precision::automatic, threads);
  StepTimes times;
  long sweeps = 0, searches = 0;
  double pairs = 0.0;
  const double begin = now();
  solver->run(control, [&](int, const State& state) {
    const StepReport& r = state.report;
    times.search += r.times.search;
    times.refresh += r.times.refresh;
    times.balloon += r.times.balloon;
    times.wall += r.times.wall;
    times.rest += r.times.rest;
    sweeps += r.sweeps;
    searches += r.searches;
    pairs += r.pair_count;
  });
  const double whole = now() - begin;
  const int frames = control.inflator.frame_count() - 1;
  const auto ms = [&](double seconds) { return 1e3 * seconds / frames; };
  const double inside = times.search + times.refresh + times.balloon + times.wall + times.rest;
  std::vector<std::string> row{c.name,
                               std::to_string(scene.bodies.wall().count),
                               backend_name(gpu ? 0 : threads),
                               formatted("%.1f", frames / whole),
                               formatted("%.1f", double(sweeps) / frames),
                               formatted("%.2f", double(searches) / frames),
                               formatted("%.0f", pairs / frames)};
  for (const double part :
       {times.search, times.refresh, times.balloon, times.wall, times.rest, whole - inside})
    row.push_back(formatted("%.3f", ms(part)));
  results.row(row);
}

void print_split_head(const char* title, ResultTable& results) {
  results.section(title);
  results.paragraph("The parts of a frame are in ms; `host` is what passes outside the step.");
  results.columns({"balloon", "wall vertices", "backend", "frames/s", "sweeps", "searches", "pairs",
                   "search", "refresh", "balloon", "wall", "rest", "host"});
}

// The solver alone; what makes the frames' outputs comes on top and is given last.
void angioplasty(ResultTable& results) {
  print_split_head("Whole course (insert, inflate, hold, deflate, rest), frames of 25 ms", results);
  const WallCase cases[] = {{"rubber", 61, 20, false},
                            {"rubber", 148, 60, false},
                            {"rubber", 190, 80, false},
                            {"folded", 61, 20, true}};
  for (const WallCase& c : cases) {
    SimulationOptions options;
    const SimulationModel model = wall_model(c, options);
    for (const int threads : {1, 2, 0})
      if (threads > 0 || has_gpu()) print_split(c, model, options, threads == 0, threads, results);
    const Scene scene = make_scene(model, options);
    const double begin = now();
    const double crossing = max_penetration(scene, scene.start);
    std::fprintf(stderr, "  outputs: penetration (%.3f mm) %.2f ms\n", crossing,
                 1e3 * (now() - begin));
  }
}

// A shorter course with the layered wall: three layers, with plaque where the lumen is narrow.
void layered_walls(ResultTable& results) {
  print_split_head("Layered wall, frames of 25 ms, inflated within a second", results);
  const WallCase cases[] = {{"rubber", 46, 20, false}, {"rubber", 91, 40, false}};
  for (const WallCase& c : cases) {
    testing::StenosedTube p;
    p.length = 18.0;
    p.balloon_length = 9.0;
    p.wall_rings = c.rings;
    p.wall_around = c.around;
    SimulationModel model = testing::layered_model(p);
    SimulationOptions options;
    testing::use_rubber(model, options);
    options.inflation.inflate_s = 1.0;
    options.inflation.hold_s = 0.25;
    options.inflation.deflate_s = 0.5;
    options.inflation.rest_s = 0.1;
    for (const int threads : {0, 1, 2})
      if (threads > 0 || has_gpu()) print_split(c, model, options, threads == 0, threads, results);
    std::fprintf(stderr, "  %zu wedges in %d columns\n", model.layered_wall.wedges.size(),
                 int(model.wall.vertices.size()));
  }
}

// Frames a second of a whole run, without files.
void print_rate(const char* name, const SimulationModel& model, SimulationOptions options,
                ResultTable& results) {
  for (const Backend backend : {Backend::cpu, Backend::cuda}) {
    if (backend == Backend::cuda && !has_gpu()) continue;
    options.backend = backend;
    const SimulationSummary s = simulate(model, options, {});
    results.row({name, s.backend, formatted("%.1f", s.frame_count / s.wall_s),
                 formatted("%.1f", 1e6 * s.time.solver / (s.frame_count - 1) / s.mean_sweeps)});
  }
}

// The paper's contact and gas: tets are projected colour by colour.
void paper(ResultTable& results) {
  results.section("The paper's projections, 20 sweeps a frame");
  results.columns({"model", "backend", "frames/s", "solver, us a sweep"});
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.inflation.control = InflationControl::pressure;
  options.inflation.peak_pressure_atm = 2.0;
  options.inflation.inflate_s = options.inflation.deflate_s = 1.0;
  options.contact.model = ContactModel::paper;
  print_rate("contact", testing::model_in_a_bag(1.0, 1.3, 61, 20), options, results);
  options.contact.model = ContactModel::barrier;
  options.gas_model = GasModel::per_tet;
  options.inflation.control = InflationControl::volume;
  SimulationModel model = paper_balloon();
  for (int i = 0; i < 24; ++i) model.guidewire.push_back({0.0, 0.0, 10.0 * (i / 23.0 - 0.5)});
  options.inflation.peak_volume_mm3 = 1.5 * enclosed_volume(model.balloon);
  print_rate("gas", model, options, results);
}

// Everything that a frame is: solver, air mesh, outputs.
SimulationSummary whole_run(const SimulationModel& model, Backend backend) {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.inflation.peak_pressure_atm = 4.0;
  options.backend = backend;
  return simulate(model, options, {});
}

// A balloon against a vessel of its own pattern of triangles, where an air mesh needs no mesher.
void air_mesh(ResultTable& results) {
  const SimulationModel with = testing::model_in_a_bag(1.0, 1.3, 61, 20);
  SimulationModel without = with;
  without.air.clear();
  results.section("Whole course with an air mesh that flips and with all outputs");
  results.paragraph(formatted("%zu vertices, %zu tets.",
                              with.balloon.vertices.size() + with.wall.vertices.size(),
                              with.air.size()));
  results.columns(
      {"backend", "frames/s", "without the air mesh", "flips a frame", "frames without whole air"});
  for (const Backend backend : {Backend::cpu, Backend::cuda}) {
    if (backend == Backend::cuda && !has_gpu()) continue;
    const SimulationSummary air = whole_run(with, backend), plain = whole_run(without, backend);
    results.row({air.backend, formatted("%.1f", air.frame_count / air.wall_s),
                 formatted("%.1f", plain.frame_count / plain.wall_s),
                 formatted("%.1f", double(air.flip_count) / air.frame_count),
                 std::to_string(air.frames_without_air)});
  }
}

using Frames = std::vector<std::vector<Vec3>>;

Frames frames_of(const SimulationModel& model, const SimulationOptions& options, bool gpu,
                 Precision precision) {
  const Scene scene = make_scene(model, options);
  const double volume = balloon_volume(scene, scene.start);
  TriangleMesh rest = model.balloon;
  rest.vertices = model.balloon_rest;
  const Control control = make_control(scene, options, std::max(volume, enclosed_volume(rest)));
  const auto solver = gpu ? make_cuda_solver(scene, options, precision)
                          : make_cpu_solver(scene, options, precision);
  Frames frames;
  solver->run(control, [&](int, const State& state) { frames.push_back(state.x); });
  return frames;
}

// A few frames of small scenes, for tools that watch a program's memory.
void check() {
  if (!has_gpu()) return;
  SimulationOptions options = ramp();
  options.inflation.inflate_s = 0.3;
  options.inflation.hold_s = 0.0;
  testing::StenosedTube p;
  p.length = 18.0;
  p.balloon_length = 9.0;
  p.balloon_rings = 13;
  p.balloon_around = 12;
  p.wall_rings = 31;
  p.wall_around = 14;
  p.start_radius = 0.7;
  SimulationOptions lesion;
  lesion.inflation.inflate_s = 0.25;
  lesion.inflation.hold_s = lesion.inflation.rest_s = 0.0;
  lesion.inflation.deflate_s = 0.05;
  for (const Spread spread : {Spread::block, Spread::grid})
    for (const bool wall : {false, true}) {
      SimulationModel model = wall ? testing::make_model(p) : paper_balloon(13, 12);
      if (!wall) model.balloon_fixed.back() = model.balloon_fixed.end()[-2] = 1;  // or it drifts
      const Scene scene = make_scene(model, wall ? lesion : options);
      const double volume = balloon_volume(scene, scene.start);
      const Control control = make_control(scene, wall ? lesion : options, 4.0 * volume);
      const auto solver =
          make_cuda_solver(scene, wall ? lesion : options, Precision::single, spread);
      const auto reference = make_cpu_solver(scene, wall ? lesion : options, Precision::single);
      std::vector<std::vector<Vec3>> expected;
      reference->run(control, [&](int, const State& s) { expected.push_back(s.x); });
      double worst = 0.0;
      int contacts = 0;
      solver->run(control, [&](int f, const State& s) {
        for (std::size_t v = 0; v < s.x.size(); ++v)
          worst = std::max(worst, distance(s.x[v], expected[std::size_t(f)][v]));
        contacts = std::max(contacts, s.report.contact_count);
      });
      std::printf("check %s %s: differs from the CPU by %.2e mm, contacts %d\n",
                  spread == Spread::grid ? "grid" : "block", wall ? "wall" : "free", worst,
                  contacts);
    }
}

void report_difference(const std::string& what, const Frames& a, const Frames& b,
                       ResultTable& results) {
  double worst = 0.0, mean = 0.0;
  std::size_t at = 0, count = 0;
  for (std::size_t f = 0; f < std::min(a.size(), b.size()); ++f)
    for (std::size_t v = 0; v < a[f].size(); ++v) {
      const double d = distance(a[f][v], b[f][v]);
      mean += d;
      ++count;
      if (d > worst) worst = d, at = f;
    }
  results.row({what, formatted("%.2e", worst), formatted("%zu of %zu", at, a.size()),
               formatted("%.2e", mean / double(count))});
}

// Of every other vertex of the balloon at the start [mm].
constexpr double kNudge = 1e-9;

void compare(const std::string& name, const SimulationModel& model,
             const SimulationOptions& options, ResultTable& results) {
  const Frames single = frames_of(model, options, false, Precision::single);
  const Frames twofold = frames_of(model, options, false, Precision::double_);
  report_difference(name + "CPU float, CPU double", single, twofold, results);
  SimulationModel nudged = model;
  for (std::size_t v = 0; v < model.balloon.vertices.size(); v += 2)
    if (model.balloon_fixed[v] == 0) nudged.balloon.vertices[v].x += kNudge;
  report_difference(name + "CPU double, start moved by 1e-9 mm", twofold,
                    frames_of(nudged, options, false, Precision::double_), results);
  if (!has_gpu()) return;
  const Frames gpu = frames_of(model, options, true, Precision::single);
  const Frames again = frames_of(model, options, true, Precision::single);
  const Frames gpu_twofold = frames_of(model, options, true, Precision::double_);
  report_difference(name + "CUDA float, run again", gpu, again, results);
  report_difference(name + "CPU float, CUDA float", single, gpu, results);
  report_difference(name + "CPU double, CUDA double", twofold, gpu_twofold, results);
}

void compare(ResultTable& results) {
  results.section("Backends and precisions against each other, 200 frames");
  results.columns({"compared", "worst mm", "in frame", "mean mm"});
  SimulationOptions free_options = ramp();
  free_options.inflation.hold_s = 1.5;
  free_options.inflation.deflate_s = 0.975;
  SimulationModel pinned = paper_balloon();  // or it drifts
  pinned.balloon_fixed[pinned.balloon_fixed.size() - 1] = 1;
  pinned.balloon_fixed[pinned.balloon_fixed.size() - 2] = 1;
  SimulationOptions lesion;
  lesion.frame_s = 0.02;
  lesion.inflation.inflate_s = 2.0;
  lesion.inflation.hold_s = 0.5;
  lesion.inflation.deflate_s = 1.2;
  lesion.inflation.rest_s = 0.28;
  SimulationOptions rubber = lesion;
  const SimulationModel in_tube = wall_model({"rubber", 61, 20, false}, rubber);
  compare("free balloon: ", pinned, free_options, results);
  compare("rubber in a stenosis: ", in_tube, rubber, results);
  compare("folded in a stenosis: ", testing::make_model(testing::small_stenosis()), lesion,
          results);
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
