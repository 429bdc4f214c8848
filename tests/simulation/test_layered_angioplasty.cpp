#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "simulation/bodies/scene.hpp"
#include "testing/simulation/layered.hpp"

/// A balloon in a narrowed vessel whose wall is the layered solid.
namespace angio::simulation {
namespace {

using testing::layered_model;
using testing::layered_options;

// Twice the least mean radius of the wall's rings.
double throat_diameter(const SimulationFrame& frame) {
  const auto around = std::size_t(testing::layered_tube().wall_around);
  double least = 1e9;
  for (std::size_t ring = 0; ring < frame.wall.size(); ring += around) {
    double sum = 0.0;
    for (std::size_t k = 0; k < around; ++k)
      sum += std::hypot(frame.wall[ring + k].x, frame.wall[ring + k].y);
    least = std::min(least, sum / double(around));
  }
  return 2.0 * least;
}

TEST(LayeredAngioplasty, WidensThePlaqueForGoodAndRecoils) {
  const SimulationModel model = layered_model();
  double start = 0.0, peak = 0.0, end = 0.0, kept = 0.0, moved_before_contact = 0.0;
  double low = 1.0, high = 1.0;
  bool touched = false;
  const SimulationSummary summary =
      simulate(model, layered_options(), [&](const SimulationFrame& f) {
        end = throat_diameter(f);
        if (f.frame == 0) start = end;
        peak = std::max(peak, end);
        touched = touched || f.contact.count > 0;
        ASSERT_EQ(f.layered_wall.size(), model.layered_wall.vertices.size());
        const std::vector<WallStress> stresses = f.wall_stress();
        ASSERT_EQ(stresses.size(), model.layered_wall.wedges.size());
        for (std::size_t v = 0; v < f.layered_wall.size() && !touched; ++v)
          moved_before_contact = std::max(
              moved_before_contact, distance(f.layered_wall[v], model.layered_wall.vertices[v]));
        for (std::size_t v = 0; v < f.wall.size(); ++v) ASSERT_EQ(f.wall[v], f.layered_wall[v]);
        for (const WallStress& w : stresses) {
          low = std::min(low, w.volume_ratio);
          high = std::max(high, w.volume_ratio);
        }
        kept = *std::max_element(f.plastic_strain.begin(), f.plastic_strain.end());
      });
  EXPECT_LT(moved_before_contact, 0.01);  // the wall is in balance before the balloon comes
  EXPECT_GT(peak, start + 0.3);
  EXPECT_GT(end, start + 0.1);
  EXPECT_LT(end, peak - 0.05);
  EXPECT_GT(kept, 0.01);
  EXPECT_GT(low, 0.85);
  EXPECT_LT(high, 1.15);
  EXPECT_EQ(summary.max_penetration_mm, 0.0);
}

TEST(LayeredAngioplasty, ColumnsThatMoveAtOnceShareNoPatch) {
  const SimulationModel model = layered_model();
  const detail::Scene scene = detail::make_scene(model, layered_options());
  const int columns = scene.bodies.wall().count;
  std::vector<int> color(std::size_t(columns), -1);
  for (std::size_t c = 0; c + 1 < scene.wall.color_begin.size(); ++c)
    for (int v = scene.wall.color_begin[c]; v < scene.wall.color_begin[c + 1]; ++v)
      color[std::size_t(v - scene.bodies.wall().first)] = int(c);
  const detail::SolidModel& solid = scene.wall.solid.model;
  for (int p = 0; p < solid.patch_count(); ++p) {
    std::map<int, int> mover;  // of a colour
    for (int m = solid.patch_begin[std::size_t(p)]; m < solid.patch_begin[std::size_t(p) + 1]; ++m)
      for (int a = 0; a < 6; ++a) {
        const int w = solid.patch_wedges[std::size_t(m)];
        const int column = solid.corners[std::size_t(6 * w + a)] % columns;
        const int c = color[std::size_t(column)];
        if (c >= 0) {
          EXPECT_EQ(mover.emplace(c, column).first->second, column) << p;
        }
      }
  }
}

// A column that is held for the wall's own equilibria and has no wedges: it goes with the others,
// and the vessel is widened as if it were whole.
TEST(LayeredAngioplasty, ColumnsWithoutLayersGoWithTheirNeighbors) {
  const SimulationModel whole = layered_model();
  SimulationModel model = whole;
  LayeredWall& wall = model.layered_wall;
  const auto around = std::size_t(testing::layered_tube().wall_around);
  const std::size_t columns = model.wall.vertices.size(), led = columns / 2 / around * around + 3;
  for (std::size_t v = led; v < wall.fixed.size(); v += columns) wall.fixed[v] = 1;
  std::vector<char> drop;
  for (const Wedge& wedge : wall.wedges)
    drop.push_back(std::any_of(wedge.begin(), wedge.end(),
                               [&](int v) { return std::size_t(v) % columns == led; }));
  const auto keep = [&](auto& values) {
    std::size_t i = 0;
    std::erase_if(values, [&](const auto&) { return drop[i++] != 0; });
  };
  keep(wall.wedges);
  keep(wall.layer);
  keep(wall.region);
  keep(wall.axial);
  const auto neighbors = vertex_neighbors(model.wall)[led];
  const auto peak_of = [&](const SimulationModel& of, bool is_led) {
    double peak = 0.0;
    simulate(of, layered_options(), [&](const SimulationFrame& f) {
      peak = std::max(peak, throat_diameter(f));
      if (!is_led) return;
      Vec3 mean;
      for (const int n : neighbors)
        mean += (1.0 / double(neighbors.size())) *
                (f.wall[std::size_t(n)] - model.wall.vertices[std::size_t(n)]);
      // It went there in its turn of the last sweep; the neighbours have moved on since.
      EXPECT_LT(norm(f.wall[led] - model.wall.vertices[led] - mean), 0.01) << f.frame;
    });
    return peak;
  };
  const double start = testing::layered_tube().radius * 2.0 * (1.0 - 0.4);
  const double of_whole = peak_of(whole, false);
  EXPECT_GT(of_whole, start + 0.3);
  EXPECT_NEAR(peak_of(model, true), of_whole, 0.1 * (of_whole - start));
}

SimulationOptions short_options() {
  SimulationOptions options = layered_options();
  options.frame_s = 0.025;
  options.inflation.inflate_s = 0.3;
  options.inflation.hold_s = options.inflation.rest_s = 0.0;
  options.inflation.deflate_s = 0.1;
  return options;
}

TEST(LayeredAngioplasty, BeginsWithThePreStressThatItIsGiven) {
  SimulationModel model = layered_model();
  SimulationOptions shorter = short_options();
  shorter.inflation.inflate_s = shorter.inflation.deflate_s = 2.0 * shorter.frame_s;
  const auto begin = [&] {
    std::pair<std::vector<WallStress>, std::vector<Vec3>> stress_then_shape;
    simulate(model, shorter, [&](const SimulationFrame& f) {
      if (f.frame == 0) stress_then_shape.first = f.wall_stress();
      if (f.frame == 1) stress_then_shape.second = f.layered_wall;
    });
    return stress_then_shape;
  };
  const auto found = begin();
  model.wall_seen =
      std::make_shared<WallSolution>(prestress_wall(model.layered_wall, shorter.layered_wall));
  EXPECT_EQ(begin().second, found.second);
  WallSolution none;
  none.state = unloaded_state(model.layered_wall);
  none.converged = true;
  model.wall_seen = std::make_shared<WallSolution>(none);
  double most_found = 0.0, most_none = 0.0;
  for (const WallStress& w : found.first) most_found = std::max(most_found, w.principal_kpa);
  for (const WallStress& w : begin().first) most_none = std::max(most_none, w.principal_kpa);
  EXPECT_GT(most_found, 10.0);
  EXPECT_LT(most_none, 1e-6);
}

TEST(LayeredAngioplasty, GivesTheSameBitsForOneAndTwoThreads) {
  const SimulationModel model = layered_model();
  const SimulationOptions options = short_options();
  std::vector<std::vector<Vec3>> last;
  const int before = omp_get_max_threads();
  for (const int threads : {1, 2}) {
    omp_set_num_threads(threads);
    simulate(model, options, [&](const SimulationFrame& f) {
      if (f.frame == 8) last.push_back(f.layered_wall);
    });
  }
  omp_set_num_threads(before);
  ASSERT_EQ(last.size(), 2u);
  EXPECT_EQ(last[0], last[1]);
  EXPECT_NE(last[0], model.layered_wall.vertices);
}

}  // namespace
}  // namespace angio::simulation
