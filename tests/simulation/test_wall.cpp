#include <gtest/gtest.h>

#include "core/units.hpp"
#include "simulation/detail/launch.hpp"
#include "simulation/detail/step_view.hpp"
#include "tests/simulation/models.hpp"

namespace angio::simulation::detail {
namespace {

// A healthy tube whose wall is moved by hand; the balloon is far away inside.
struct Wall {
  SimulationModel model;
  SimulationOptions options;
  Scene scene;
  std::vector<Vec3> x;  // the scene's origin is zero
  HostMemory memory;
  StepView<double> view;

  explicit Wall(int around = 32) {
    testing::StenosedTube p;
    p.stenosis = 0.0;
    p.wall_around = around;
    p.wall_rings = 4 * around;
    model = testing::make_model(p);
    options.wall.foundation_kpa_per_mm = 0.0;
    scene = make_scene(model, options);
    x = scene.start;
    view = make_view<double>(scene, options, memory);
    view.dt = 1e6;  // no inertia
    view.x = view.x_inertial = x.data();
  }
  Wall(const Wall&) = delete;

  void fit() {
    for (int c = 0; c < scene.clusters.count(); ++c) fit_cluster(view, c, OneLane{});
    for (int i = 0; i < scene.wall_count; ++i) set_goal(view, i);
  }
};

TEST(Wall, EveryVertexBelongsToASlabAndSlabsOverlap) {
  const Wall wall;
  const WallClusters& c = wall.scene.clusters;
  int shared = 0;
  for (int v = 0; v < wall.scene.wall_count; ++v) {
    const int count = c.entry_begin[std::size_t(v) + 1] - c.entry_begin[std::size_t(v)];
    EXPECT_GE(count, 1);
    shared += count > 1;
  }
  EXPECT_GT(shared, 9 * wall.scene.wall_count / 10);
  for (int i = 0; i < c.count(); ++i) {
    EXPECT_NEAR(c.radius[std::size_t(i)], 1.5, 0.02);
    EXPECT_NEAR(std::abs(c.axis[std::size_t(i)].z), 1.0, 1e-3);
    EXPECT_TRUE(c.ring[std::size_t(i)]);
  }
}

TEST(Wall, CarriesTheThinRingsPressureWhenWidened) {
  Wall wall;
  const double r = 1.5, dr = 0.03, ratio = wall.options.wall.thickness_ratio;
  const double thickness = 2.0 * r * ratio / (1.0 - 2.0 * ratio);
  for (std::size_t v = std::size_t(wall.scene.balloon_count); v < wall.x.size(); ++v) {
    wall.x[v].x *= (r + dr) / r;
    wall.x[v].y *= (r + dr) / r;
  }
  wall.fit();
  double force = 0.0, area = 0.0;
  for (int i = 0; i < wall.scene.wall_count; ++i) {
    const int v = wall.scene.balloon_count + i;
    const Vec3 outward = normalized(Vec3{wall.x[std::size_t(v)].x, wall.x[std::size_t(v)].y, 0.0});
    force -= dot(wall_forces(wall.view, v, OneLane{}).force, outward);
    area += wall.scene.wall_area[std::size_t(i)];
  }
  const double expected = 1e6 * thickness * dr / (r * r);  // E t dr / r^2, E = 1 MPa
  EXPECT_NEAR(force / area, expected, 0.02 * expected);
}

TEST(Wall, FeelsNothingOfARigidMotion) {
  Wall wall(16);
  const double c = std::cos(0.4), s = std::sin(0.4);
  for (std::size_t v = std::size_t(wall.scene.balloon_count); v < wall.x.size(); ++v) {
    const Vec3 p = wall.x[v];
    wall.x[v] = {p.x + 0.3, c * p.y - s * p.z - 1.0, s * p.y + c * p.z};
  }
  wall.fit();
  for (int i = 0; i < wall.scene.wall_count; ++i) {
    const VertexForces<double> f = wall_forces(wall.view, wall.scene.balloon_count + i, OneLane{});
    EXPECT_LT(norm(f.force), 1e-6 * wall.view.goal_stiffness[i]);
  }
}

TEST(Wall, StretchOfAWidenedSlabIsItsWidening) {
  Wall wall(16);
  for (std::size_t v = std::size_t(wall.scene.balloon_count); v < wall.x.size(); ++v) {
    wall.x[v].x *= 1.3;
    wall.x[v].y *= 1.3;
  }
  wall.fit();
  const Mat3 stretch = cluster_stretch(wall.view, wall.scene.clusters.count() / 2, OneLane{});
  EXPECT_NEAR(stretch(0, 0), 1.3, 1e-4);
  EXPECT_NEAR(stretch(1, 1), 1.3, 1e-4);
  EXPECT_NEAR(stretch(2, 2), 1.0, 1e-4);
}

}  // namespace
}  // namespace angio::simulation::detail
