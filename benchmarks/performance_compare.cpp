#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "benchmarks/performance_parts.hpp"
#include "simulation/backends/step_solver.hpp"
#include "testing/simulation/small_stenosis.hpp"

namespace angio::simulation {

using namespace detail;

namespace {

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

}  // namespace

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

}  // namespace angio::simulation
