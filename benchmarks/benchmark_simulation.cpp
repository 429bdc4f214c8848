#include <benchmark/benchmark.h>

#include "simulation/contact/candidates.hpp"
#include "simulation/run/measure.hpp"
#include "testing/simulation/models.hpp"

/// The solver on the seed paper's sizes: a balloon of 522 vertices in walls of 1220 vertices
/// (Table 2, unilateral) and more.
namespace angio::simulation {
namespace {

SimulationModel model_with_wall(int around) {
  testing::StenosedTube p;
  p.wall_around = around;
  p.wall_rings = 61 * around / 20;
  return testing::make_model(p);
}

// Frames a second over the whole course: insertion, inflation, hold, deflation, rest.
void angioplasty(benchmark::State& state) {
  const SimulationModel model = model_with_wall(int(state.range(0)));
  int frames = 0;
  for (auto _ : state) frames += simulate(model, {}, {}).frame_count;
  state.counters["wall_vertices"] = double(model.wall.vertices.size());
  state.counters["frames_per_second"] =
      benchmark::Counter(double(frames), benchmark::Counter::kIsRate);
}
BENCHMARK(angioplasty)
    ->Arg(20)
    ->Arg(40)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(1);

// The balloon alone.
void free_inflation(benchmark::State& state) {
  SimulationModel model = model_with_wall(20);
  model.wall = {};
  model.wall_fixed.clear();
  model.wall_abscissa.clear();
  model.wall_group.clear();
  int frames = 0;
  for (auto _ : state) frames += simulate(model, {}, {}).frame_count;
  state.counters["frames_per_second"] =
      benchmark::Counter(double(frames), benchmark::Counter::kIsRate);
}
BENCHMARK(free_inflation)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(1);

void contact_detection(benchmark::State& state) {
  const SimulationModel model = model_with_wall(int(state.range(0)));
  const detail::Scene scene = detail::make_scene(model, {});
  std::vector<Vec3> x = scene.start;  // the balloon blown up to the throat
  for (int v = 0; v < scene.bodies.balloon().count; ++v) {
    x[std::size_t(v)].x *= 1.8;
    x[std::size_t(v)].y *= 1.8;
  }
  std::size_t pairs = 0;
  for (auto _ : state) {
    pairs = detail::find_candidates(scene, x, 0.39).size();
    benchmark::DoNotOptimize(pairs);
  }
  state.counters["candidates"] = double(pairs);
}
BENCHMARK(contact_detection)->Arg(20)->Arg(60)->Unit(benchmark::kMicrosecond)->UseRealTime();

void frame_measures(benchmark::State& state) {
  const SimulationModel model = model_with_wall(int(state.range(0)));
  const detail::Scene scene = detail::make_scene(model, {});
  for (auto _ : state) benchmark::DoNotOptimize(detail::max_penetration(scene, scene.start));
}
BENCHMARK(frame_measures)->Arg(20)->Arg(60)->Unit(benchmark::kMicrosecond)->UseRealTime();

}  // namespace
}  // namespace angio::simulation
