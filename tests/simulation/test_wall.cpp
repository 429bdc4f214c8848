#include <gtest/gtest.h>

#include <numbers>

#include "core/units.hpp"
#include "simulation/backends/host_memory.hpp"
#include "simulation/step/make_views.hpp"
#include "simulation/step/sweep_slabs.hpp"
#include "simulation/step/team.hpp"
#include "testing/simulation/models.hpp"

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

  explicit Wall(int around = 32, WallMaterial material = {}, double stenosis = 0.0,
                double healthy_radius = 1.5) {
    testing::StenosedTube p;
    p.stenosis = stenosis;
    p.eccentric = stenosis > 0.0;
    options.wall = material;
    p.wall_around = around;
    p.wall_rings = 4 * around;
    model = testing::make_model(p);
    model.reference_radius_mm = healthy_radius;
    options.wall.foundation_kpa_per_mm = 0.0;
    scene = make_scene(model, options);
    x = scene.start;
    view = make_view<double>(scene, options, memory);
    view.motion.dt = 1e6;  // no inertia
    view.motion.x = view.motion.x_inertial = x.data();
  }
  Wall(const Wall&) = delete;

  template <class Map>
  void shape(const Map& map) {
    for (std::size_t v = std::size_t(scene.bodies.wall().first); v < x.size(); ++v)
      x[v] = map(x[v]);
  }
  void let_flow(const PlasticFlow<double>& law, double time) {
    fit();
    view.motion.dt = time;
    for (int c = 0; c < scene.wall.slabs.count(); ++c) flow_slab(view, law, c, OneLane{});
    view.motion.dt = 1e6;
  }
  // Long enough for all strain to flow, and for the rotations to follow.
  void let_all_flow() {
    for (int step = 0; step < 100; ++step) let_flow({0.0, 100.0, 10.0}, 10.0);
    fit();
  }
  // The farthest that a vertex is from its goal [mm].
  double most_off() const {
    double most = 0.0;
    for (int i = 0; i < scene.bodies.wall().count; ++i)
      most = std::max(
          most, distance(x[std::size_t(scene.bodies.wall().first + i)], view.slabs.goals.goal[i]));
    return most;
  }
  // By its stiffness along the vessel.
  Vec3 force_along(int i) const {
    const Vec3 off = x[std::size_t(scene.bodies.wall().first + i)] - view.slabs.goals.goal[i];
    return view.slabs.goals.along_force[i] - view.slabs.goals.along_stiffness[i] * off;
  }
  // 1/2 sum k (n . (x - centre) - a . q)^2 over the rings, for which fit_slab finds n
  double energy_along() {
    fit();
    double sum = 0.0;
    for (int c = 0; c < scene.wall.slabs.count(); ++c)
      for (int e = view.slabs.shape.begin[c]; e < view.slabs.shape.begin[c + 1]; ++e) {
        const Vec3& p = x[std::size_t(scene.bodies.wall().first + view.slabs.shape.vertex[e])];
        const double off = dot(view.slabs.fit.axis[c], p - view.slabs.fit.centre[c]) -
                           dot(view.slabs.shape.axis[c], plastic_offset(view, c, e));
        sum += 0.5 * view.slabs.shape.along[c] * view.slabs.shape.stiffness[e] * off * off;
      }
    return sum;
  }
  void fit() {
    for (int c = 0; c < scene.wall.slabs.count(); ++c) fit_slab(view, c, OneLane{});
    for (int i = 0; i < scene.bodies.wall().count; ++i) set_goal(view, i);
  }
};

TEST(Wall, EveryVertexBelongsToASlabAndSlabsOverlap) {
  const Wall wall;
  const WallSlabs& c = wall.scene.wall.slabs;
  int shared = 0;
  for (int v = 0; v < wall.scene.bodies.wall().count; ++v) {
    const int count = c.slab_vertex_begin[std::size_t(v) + 1] - c.slab_vertex_begin[std::size_t(v)];
    EXPECT_GE(count, 1);
    shared += count > 1;
  }
  EXPECT_GT(shared, 9 * wall.scene.bodies.wall().count / 10);
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
  for (std::size_t v = std::size_t(wall.scene.bodies.wall().first); v < wall.x.size(); ++v) {
    wall.x[v].x *= (r + dr) / r;
    wall.x[v].y *= (r + dr) / r;
  }
  wall.fit();
  double force = 0.0, area = 0.0;
  for (int i = 0; i < wall.scene.bodies.wall().count; ++i) {
    const int v = wall.scene.bodies.wall().first + i;
    const Vec3 outward = normalized(Vec3{wall.x[std::size_t(v)].x, wall.x[std::size_t(v)].y, 0.0});
    force -= dot(wall_forces(wall.view, v, OneLane{}).force, outward);
    area += wall.scene.wall.area[std::size_t(i)];
  }
  const double expected = 1e6 * thickness * dr / (r * r);  // E t dr / r^2, E = 1 MPa
  EXPECT_NEAR(force / area, expected, 0.02 * expected);
}

Vec3 ruffled(const Vec3& p) {
  return {p.x + 0.2 * std::sin(2.0 * p.z + p.y), 1.1 * p.y - 0.1 * p.z,
          0.8 * p.z + 0.15 * std::cos(3.0 * p.x)};
}

TEST(Wall, PressedTogetherBearsWhatWallAndPlaqueBearThatCannotGiveWay) {
  const double r = 1.5, strain = -0.02, ratio = WallMaterial().thickness_ratio;
  const double modulus = 0.52 / (1.48 * 0.04);  // of E = 1 MPa: confined, Poisson's ratio 0.48
  for (const double healthy : {1.5, 2.0}) {
    Wall wall(32, {}, 0.0, healthy);
    wall.shape([&](const Vec3& p) { return Vec3{p.x, p.y, (1.0 + strain) * p.z}; });
    wall.fit();
    // The mean over all sections of the force through them is that of z f over the length.
    double moment = 0.0, area = 0.0;
    for (int i = 0; i < wall.scene.bodies.wall().count; ++i) {
      moment -= wall.force_along(i).z *
                wall.scene.start[std::size_t(wall.scene.bodies.wall().first + i)].z;
      area += wall.scene.wall.area[std::size_t(i)];
    }
    const double depth =
        2.0 * r * ratio / (1.0 - 2.0 * ratio) + (healthy * healthy - r * r) / (2.0 * r);
    const double expected = 1e6 * modulus * depth * strain;
    EXPECT_NEAR(moment / area, expected, 0.02 * std::abs(expected));
  }
}

TEST(Wall, ForceAlongTheVesselIsTheEnergysSlope) {
  Wall wall(16, {}, 0.4);
  wall.shape(ruffled);
  for (int i = 0; i < 5; ++i) wall.fit();
  const double h = 1e-5;
  for (int i = 7; i < wall.scene.bodies.wall().count; i += 131)
    for (int axis = 0; axis < 3; ++axis) {
      wall.fit();
      const double force = wall.force_along(i)[axis], whole = norm(wall.force_along(i));
      double& p = wall.x[std::size_t(wall.scene.bodies.wall().first + i)][axis];
      const double at = p;
      p = at + h;
      const double more = wall.energy_along();
      p = at - h;
      const double less = wall.energy_along();
      p = at;
      EXPECT_NEAR(-(more - less) / (2.0 * h), force, 1e-6 * whole + 1e-3);
    }
}

TEST(Wall, ForcesAlongTheVesselHaveNoSumAndNoTorque) {
  Wall wall(16, {}, 0.4);
  wall.shape(ruffled);
  for (int i = 0; i < 5; ++i) wall.fit();
  Vec3 sum, torque;
  double size = 0.0;
  for (int i = 0; i < wall.scene.bodies.wall().count; ++i) {
    const Vec3 f = wall.force_along(i), p = wall.x[std::size_t(wall.scene.bodies.wall().first + i)];
    sum += f;
    torque += cross(p, f);
    size += norm(f);
  }
  EXPECT_LT(norm(sum), 1e-10 * size);
  EXPECT_LT(norm(torque), 1e-9 * size);
}

TEST(Wall, FeelsNothingOfARigidMotion) {
  Wall wall(16);
  const double c = std::cos(0.4), s = std::sin(0.4);
  for (std::size_t v = std::size_t(wall.scene.bodies.wall().first); v < wall.x.size(); ++v) {
    const Vec3 p = wall.x[v];
    wall.x[v] = {p.x + 0.3, c * p.y - s * p.z - 1.0, s * p.y + c * p.z};
  }
  wall.fit();
  for (int i = 0; i < wall.scene.bodies.wall().count; ++i) {
    const VertexForces<double> f =
        wall_forces(wall.view, wall.scene.bodies.wall().first + i, OneLane{});
    EXPECT_LT(norm(f.force), 1e-6 * wall.view.slabs.goals.stiffness[i]);
  }
}

TEST(Wall, StretchOfAWidenedSlabIsItsWidening) {
  Wall wall(16);
  wall.shape([](const Vec3& p) { return Vec3{1.3 * p.x, 1.3 * p.y, p.z}; });
  wall.fit();
  const Mat3 stretch = elastic_map(wall.view, wall.scene.wall.slabs.count() / 2, OneLane{}).linear;
  EXPECT_NEAR(stretch(0, 0), 1.3, 1e-6);
  EXPECT_NEAR(stretch(1, 1), 1.3, 1e-6);
  EXPECT_NEAR(stretch(2, 2), 1.0, 1e-6);
}

// Mueller 2005, figure 4: what the quadratic columns are for.
struct Deformation {
  const char* name;
  Vec3 (*of)(const Vec3&);
};
const Deformation kQuadratic[]{{"bent",
                                [](const Vec3& p) {
                                  return Vec3{p.x + 0.02 * p.z * p.z, p.y, p.z - 0.04 * p.x * p.z};
                                }},
                               {"twisted",
                                [](const Vec3& p) {
                                  return Vec3{p.x - 0.05 * p.y * p.z, p.y + 0.05 * p.x * p.z, p.z};
                                }},
                               {"sheared in length",
                                [](const Vec3& p) {
                                  return Vec3{p.x, p.y + 0.03 * p.z * p.z, p.z};
                                }},
                               {"conical",
                                [](const Vec3& p) {
                                  return (1.0 + 0.04 * p.z) * Vec3{p.x, p.y, 0.0} + Vec3{0, 0, p.z};
                                }},
                               {"widened on one side", [](const Vec3& p) {
                                  return Vec3{p.x + 0.1 * p.x * p.x, p.y + 0.1 * p.x * p.y, p.z};
                                }}};

TEST(QuadraticWall, FeelsNothingOfARigidMotion) {
  WallMaterial material;
  material.shape = WallShape::quadratic;
  for (const double beta : {0.0, 0.5, 1.0}) {
    material.shape_beta = beta;
    Wall wall(16, material, 0.4);
    const double c = std::cos(0.4), s = std::sin(0.4);
    wall.shape([&](const Vec3& p) {
      return Vec3{p.x + 0.3, c * p.y - s * p.z - 1.0, s * p.y + c * p.z};
    });
    for (int i = 0; i < 5; ++i) wall.fit();  // the rotation goes on from the last one
    EXPECT_LT(wall.most_off(), 1e-9);
  }
}

TEST(QuadraticWall, ResistsUnevenShapesByOneLessBeta) {
  WallMaterial material;
  material.shape = WallShape::quadratic;
  for (const double beta : {0.0, 0.3, 1.0}) {
    material.shape_beta = beta;
    Wall wall(16, material, 0.4);
    wall.shape(kQuadratic[4].of);
    wall.fit();
    // What the goals of a slab leave of its modes.
    const int c = wall.scene.wall.slabs.count() / 2;
    double most = 0.0;
    for (int k = 0; k < kShapeModes; ++k) {
      const Vec3 all = best_mode(wall.view, c, k, wall.view.slabs.fit.centre[c], OneLane{});
      const Vec3 left = all - wall.view.slabs.fit.map_modes[c * kShapeModes + k];
      EXPECT_LT(norm(left - (1.0 - beta) * all), 1e-12);
      most = std::max(most, norm(all));
    }
    EXPECT_GT(most, 0.01);
  }
}

TEST(QuadraticWall, KeepsABentTwistedOrShearedShapeAsItsPlasticShape) {
  WallMaterial material;
  material.shape = WallShape::quadratic;
  for (const Deformation& d : kQuadratic) {
    Wall wall(16, material, 0.4), linear(16, {}, 0.4);
    for (Wall* each : {&wall, &linear}) {
      each->shape(d.of);
      each->let_all_flow();
    }
    EXPECT_LT(wall.most_off(), 1e-9) << d.name;
    EXPECT_GT(linear.most_off(), 1e-3) << d.name;  // springs back
  }
}

TEST(Wall, KeepsTheSetOfAHeldStretchThatTheFormulaGives) {
  // S^p = l - (l - 1) exp(-T c) above yield; none below.
  const double held = 1.4, time = 0.5, creep = 2.0;
  for (const WallShape shape : {WallShape::linear, WallShape::quadratic}) {
    WallMaterial material;
    material.shape = shape;
    for (const double yield : {0.05, 0.5}) {
      Wall wall(16, material);
      wall.shape([&](const Vec3& p) { return Vec3{held * p.x, held * p.y, p.z}; });
      for (int step = 0; step < 20; ++step) wall.let_flow({yield, creep, 3.0}, time / 20);
      const double set = yield < held - 1.0 ? held - (held - 1.0) * std::exp(-time * creep) : 1.0;
      for (int c = 0; c < wall.scene.wall.slabs.count(); ++c) {
        const Mat3& plastic = wall.view.slabs.fit.plastic[c];
        EXPECT_NEAR(plastic(0, 0), set, 1e-6);
        EXPECT_NEAR(plastic(1, 1), set, 1e-6);
        EXPECT_NEAR(plastic(2, 2), 1.0, 1e-6);
      }
    }
  }
}

TEST(Wall, IsAtRestInItsPlasticShape) {
  const double held = 1.4, yield = 0.05;
  Wall wall(16);
  wall.shape([&](const Vec3& p) { return Vec3{held * p.x, held * p.y, p.z}; });
  for (int step = 0; step < 20; ++step) wall.let_flow({yield, 2.0, 3.0}, 0.025);
  const double set = held - (held - 1.0) * std::exp(-0.5 * 2.0);
  wall.shape([&](const Vec3& p) { return Vec3{set / held * p.x, set / held * p.y, p.z}; });
  wall.fit();
  EXPECT_LT(wall.most_off(), 1e-6);
}

}  // namespace
}  // namespace angio::simulation::detail
