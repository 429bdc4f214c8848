// random_vessels [COUNT] [cpu|cuda|anew|scales|scales-cuda] [FIRST] [--markdown FILE]: balloons of
// random sizes, some folded, are inflated and emptied in random stenosed vessels: of all frames,
// the pairs of triangles that cross (balloon and wall, exact predicates), inverted tets of the air,
// frames without a whole air mesh, and frames a second. With `anew` each vessel is dilated twice on
// the CPU, the second time with an air mesh built anew for every frame: the change of the least
// lumen that is left. With `scales` each vessel is brought to a diameter from 0.6 to 25 mm, and its
// balloon is chosen as the program does: also the simulations that tell that they did not end
// right.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "core/error.hpp"
#include "simulation/balloon_size.hpp"
#include "testing/meshing/random_vessel.hpp"
#include "testing/result_table.hpp"

namespace angio::meshing {
namespace {

simulation::SimulationModel model_of(const Site& site, const BalloonSetup& setup) {
  simulation::SimulationModel model;
  model.balloon = setup.balloon.start;
  model.balloon_rest = setup.balloon.rest;
  model.balloon_fixed = setup.balloon.fixed;
  model.balloon_sliding = setup.balloon.sliding;
  model.guidewire = setup.balloon.guidewire;
  model.wall = setup.region.mesh;
  model.wall_fixed = setup.region.fixed;
  model.wall_abscissa = setup.region.abscissa;
  model.wall_group = setup.region.group;
  model.air = setup.air.tets.tets;
  model.reference_radius_mm = 0.5 * site.reference_diameter;
  const auto& points = site.vessel.tree.paths[0].points;
  const std::size_t middle = points.size() / 2;
  model.measure_point = points[middle];
  model.measure_tangent = points[middle + 1] - points[middle - 1];
  return model;
}

simulation::SimulationOptions short_inflation(const BalloonSetup& setup) {
  simulation::SimulationOptions options =
      simulation::sized(simulation::options_by_size(), setup.balloon.nominal_diameter_mm);
  options.inflation.inflate_s = 1.0;
  options.inflation.hold_s = 0.2;
  options.inflation.deflate_s = 0.6;
  options.inflation.rest_s = 0.2;
  return options;
}

struct Totals {
  int vessels = 0, refused = 0, failed = 0, frames = 0, crossings = 0, inverted = 0,
      without_air = 0;
  double seconds = 0.0;
};

void inflate(const Site& site, const BalloonSetup& setup, simulation::Backend backend,
             Totals& totals, benchmarks::ResultTable& results) {
  using benchmarks::formatted;
  const simulation::SimulationModel model = model_of(site, setup);
  simulation::SimulationOptions options = short_inflation(setup);
  options.backend = backend;
  int crossings = 0;
  double checking = 0.0;
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto summary =
      simulation::simulate(model, options, [&](const simulation::SimulationFrame& frame) {
        const auto begin = now();
        crossings += count_intersections({frame.balloon, model.balloon.triangles},
                                         {frame.wall, model.wall.triangles});
        checking += std::chrono::duration<double>(now() - begin).count();
      });
  totals.frames += summary.frame_count;
  totals.crossings += crossings;
  totals.inverted += summary.inverted_air_tets;
  totals.without_air += summary.frames_without_air;
  totals.seconds += summary.wall_s;
  totals.failed += summary.failure.empty() ? 0 : 1;
  results.row(
      {formatted("%.2f", site.reference_diameter), std::to_string(model.balloon.triangles.size()),
       std::to_string(model.wall.triangles.size()), std::to_string(setup.balloon.fold_count),
       formatted("%.1f", summary.frame_count / summary.wall_s), std::to_string(crossings),
       std::to_string(summary.inverted_air_tets), std::to_string(summary.frames_without_air),
       std::to_string(summary.air_rebuild_count),
       formatted("%.2f", 1e3 * checking / summary.frame_count),
       formatted("%.2f", summary.worst_residual), formatted("%.2f", summary.worst_pressure_ratio),
       summary.failure});
}

/// Of the largest sphere round a point that holds no vertex of the wall [mm].
double free_diameter(const Vec3& point, const std::vector<Vec3>& wall) {
  double least = std::numeric_limits<double>::max();
  for (const Vec3& p : wall) least = std::min(least, distance(p, point));
  return 2.0 * least;
}

void compare_with_anew(const Site& site, const BalloonSetup& setup,
                       benchmarks::ResultTable& results) {
  using benchmarks::formatted;
  simulation::SimulationModel model = model_of(site, setup);
  double lumen[2]{};
  int rebuilt[2]{}, frames = 0;
  for (const int anew : {0, 1}) {
    model.rebuild_each_frame = anew == 1;
    const auto summary = simulation::simulate(
        model, short_inflation(setup), [&](const simulation::SimulationFrame& f) {
          lumen[anew] = free_diameter(model.measure_point, f.wall);
        });
    rebuilt[anew] = summary.air_rebuild_count;
    frames = summary.frame_count;
  }
  results.row({formatted("%.4f", lumen[0]), std::to_string(rebuilt[0]), std::to_string(rebuilt[1]),
               std::to_string(frames),
               formatted("%.4f", 100.0 * std::abs(lumen[1] / lumen[0] - 1.0))});
}

enum class Sizes { coronary, all };

template <class Inflate>
Totals run(int count, int first, Sizes sizes, const Inflate& inflate) {
  Draw draw{std::mt19937(23)}, draw_size{std::mt19937(29)};
  Totals totals;
  for (int i = 0; i < count; ++i) {
    Site site = random_site(draw);
    BalloonOptions balloon = random_balloon(draw);
    const double diameter = random_diameter(draw_size);
    if (i < first) continue;
    if (sizes == Sizes::all) {
      const double factor = diameter / site.reference_diameter;
      site = scaled(std::move(site), factor);
      balloon = fitting_balloon(site);
    }
    try {
      const test::PlacedCase placed = test::place(site.vessel, site.abscissa, site.lesion_length,
                                                  site.reference_diameter, balloon);
      ++totals.vessels;
      inflate(site, placed.setup, totals);
    } catch (const InputError& error) {
      ++totals.refused;
      std::fprintf(stderr, "  refused: %s\n", error.what());
    }
  }
  return totals;
}

}  // namespace
}  // namespace angio::meshing

int main(int argument_count, char** arguments) {
  using namespace angio;
  try {
    benchmarks::ResultTable results("Balloons in random vessels", argument_count, arguments);
    const int count = argument_count > 1 ? std::max(1, std::atoi(arguments[1])) : 100,
              first = argument_count > 3 ? std::atoi(arguments[3]) : 0;
    const auto mode = [&](const char* name) {
      return argument_count > 2 && std::strcmp(arguments[2], name) == 0;
    };
    if (mode("anew")) {
      results.columns({"least lumen mm", "air meshes rebuilt", "rebuilt with `anew`", "frames",
                       "change of the least lumen %"});
      meshing::run(count, first, meshing::Sizes::coronary,
                   [&](const auto& site, const auto& setup, auto&) {
                     meshing::compare_with_anew(site, setup, results);
                   });
      results.write();
      return 0;
    }
    results.columns({"diameter mm", "balloon triangles", "wall triangles", "folds", "frames/s",
                     "crossings", "inverted tets", "frames without air", "air rebuilt",
                     "check ms/frame", "worst residual", "worst pressure over peak", "failure"});
    const auto backend =
        mode("cuda") || mode("scales-cuda") ? simulation::Backend::cuda : simulation::Backend::cpu;
    const auto sizes =
        mode("scales") || mode("scales-cuda") ? meshing::Sizes::all : meshing::Sizes::coronary;
    const meshing::Totals totals =
        meshing::run(count, first, sizes, [&](const auto& site, const auto& setup, auto& sums) {
          meshing::inflate(site, setup, backend, sums, results);
        });
    results.paragraph(benchmarks::formatted(
        "%d vessels (refused: %d, failed: %d), %d frames: %d crossings, %d inverted tets, "
        "%d frames without a whole air mesh; %.0f s.",
        totals.vessels, totals.refused, totals.failed, totals.frames, totals.crossings,
        totals.inverted, totals.without_air, totals.seconds));
    results.write();
    return totals.crossings > 0 || totals.inverted > 0 ? 1 : 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "random_vessels: %s\n", error.what());
    return 1;
  }
}
