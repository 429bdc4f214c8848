#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "tests/simulation/models.hpp"

/// A balloon in a narrowed vessel whose wall is the layered solid.
namespace angio::simulation {
namespace {

// The lumen extruded to the healthy wall's outside: plaque where it is narrow.
LayeredWall extruded(const TriangleMesh& lumen, const std::vector<char>& fixed, double radius,
                     double ratio) {
  const std::vector<double> level = {0.0, 0.35, 0.65, 1.0};
  const double outside = radius / (1.0 - 2.0 * ratio);
  const int count = int(lumen.vertices.size());
  LayeredWall wall;
  wall.lumen_triangles = lumen.triangles;
  for (const double share : level)
    for (int v = 0; v < count; ++v) {
      const Vec3 p = lumen.vertices[std::size_t(v)];
      const double inner = std::hypot(p.x, p.y), r = inner + share * (outside - inner);
      wall.vertices.push_back({p.x * r / inner, p.y * r / inner, p.z});
      wall.fixed.push_back(fixed[std::size_t(v)] != 0 ? 1 : 0);
    }
  for (int layer = 0; layer < 3; ++layer)
    for (const Triangle& t : lumen.triangles) {
      const int in = layer * count, out = in + count;
      wall.wedges.push_back({t[0] + in, t[1] + in, t[2] + in, t[0] + out, t[1] + out, t[2] + out});
      wall.layer.push_back(layer);
      const Vec3 p = lumen.vertices[std::size_t(t[0])];
      const bool narrow = std::hypot(p.x, p.y) < 0.9 * radius;
      wall.region.push_back(layer == 0 && narrow ? WallRegion::plaque : WallRegion(layer));
      wall.axial.push_back({0, 0, 1});
    }
  for (const Triangle& t : lumen.triangles)
    wall.outer_triangles.push_back({t[0] + 3 * count, t[1] + 3 * count, t[2] + 3 * count});
  return wall;
}

SimulationModel layered_model() {
  testing::StenosedTube p;
  p.length = 7.0;
  p.lesion_length = 4.0;
  p.balloon_length = 4.0;
  p.balloon_rings = 10;
  p.balloon_around = 10;
  p.wall_rings = 13;
  p.wall_around = 12;
  p.stenosis = 0.4;
  SimulationModel model = make_model(p);
  model.layered_wall = extruded(model.wall, model.wall_fixed, p.radius, 0.189);
  return model;
}

SimulationOptions layered_options() {
  SimulationOptions options;
  options.wall_model = WallModel::layered;
  options.frame_s = 0.1;
  options.inflation.inflate_s = 1.0;
  options.inflation.hold_s = 0.1;
  options.inflation.deflate_s = 0.6;
  options.inflation.rest_s = 0.1;
  options.inflation.peak_pressure_atm = 6.0;
  return options;
}

TEST(LayeredAngioplasty, WidensThePlaqueForGoodAndRecoils) {
  const SimulationModel model = layered_model();
  double start = 0.0, peak = 0.0, end = 0.0, kept = 0.0, moved_before_contact = 0.0;
  double low = 1.0, high = 1.0;
  bool touched = false;
  const SimulationSummary summary =
      simulate(model, layered_options(), [&](const SimulationFrame& f) {
        if (f.frame == 0) start = f.lumen_mld_mm;
        peak = std::max(peak, f.lumen_mld_mm);
        end = f.lumen_mld_mm;
        touched = touched || f.contact_count > 0;
        ASSERT_EQ(f.layered_wall.size(), model.layered_wall.vertices.size());
        ASSERT_EQ(f.wall_stress.size(), model.layered_wall.wedges.size());
        for (std::size_t v = 0; v < f.layered_wall.size() && !touched; ++v)
          moved_before_contact = std::max(
              moved_before_contact, distance(f.layered_wall[v], model.layered_wall.vertices[v]));
        for (std::size_t v = 0; v < f.wall.size(); ++v) ASSERT_EQ(f.wall[v], f.layered_wall[v]);
        for (const WallStress& w : f.wall_stress) {
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

TEST(LayeredAngioplasty, GivesTheSameBitsForOneAndTwoThreads) {
  const SimulationModel model = layered_model();
  SimulationOptions options = layered_options();
  options.inflation.inflate_s = 0.3;
  options.inflation.hold_s = options.inflation.rest_s = 0.0;
  options.inflation.deflate_s = 0.1;
  std::vector<std::vector<Vec3>> last;
  const int before = omp_get_max_threads();
  for (const int threads : {1, 2}) {
    omp_set_num_threads(threads);
    simulate(model, options, [&](const SimulationFrame& f) {
      if (f.frame == 3) last.push_back(f.layered_wall);
    });
  }
  omp_set_num_threads(before);
  ASSERT_EQ(last.size(), 2u);
  EXPECT_EQ(last[0], last[1]);
}

}  // namespace
}  // namespace angio::simulation
