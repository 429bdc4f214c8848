#include <algorithm>
#include <string>
#include <vector>

#include "benchmarks/performance_parts.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/run/measure.hpp"
#include "testing/simulation/layered.hpp"
#include "testing/simulation/matched.hpp"
#include "testing/simulation/small_stenosis.hpp"

namespace angio::simulation {

using namespace detail;

namespace {

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

// Everything that a frame is: solver, air mesh, outputs.
SimulationSummary whole_run(const SimulationModel& model, Backend backend) {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.inflation.peak_pressure_atm = 4.0;
  options.backend = backend;
  return simulate(model, options, {});
}

}  // namespace

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

}  // namespace angio::simulation
