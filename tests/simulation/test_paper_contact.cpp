#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "core/error.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/bodies/element_colors.hpp"
#include "simulation/pbd/contact.hpp"
#include "simulation/pbd/tets.hpp"
#include "testing/simulation/layered.hpp"
#include "testing/simulation/matched.hpp"

/// The seed paper's projections, with its errata.
namespace angio::simulation::detail {
namespace {

TetState<double> random_tet(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0), mass(0.1, 10.0);
  TetState<double> t;
  for (int i = 0; i < 4; ++i) {
    t.x[i] = {u(random), u(random), u(random)};
    t.before[i] = t.x[i] + 0.1 * Vec3{u(random), u(random), u(random)};
    t.inverse_mass[i] = 1.0 / mass(random);
  }
  return t;
}

Vec3 moved_mass(const TetState<double>& t, const AirProjection<double>& p) {
  Vec3 sum;
  for (int i = 0; i < 4; ++i) sum += (1.0 / t.inverse_mass[i]) * p.by[i];
  return sum;
}

TEST(PbdContact, ProjectingTheVolumeReachesItsTargetAndKeepsTheMomentum) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 100; ++trial) {
    TetState<double> t = random_tet(random);
    for (int k = 0; k < 30; ++k) {  // Newton's steps on one number
      const auto p = project_volume(t, 0.01);
      EXPECT_LT(norm(moved_mass(t, p)), 1e-12);
      for (int i = 0; i < 4; ++i) t.x[i] += p.by[i];
    }
    EXPECT_NEAR(signed_volume(t.x), 0.01, 1e-9);
  }
}

TEST(PbdContact, TheViscousItemDrawsAVertexAndItsTriangleTogether) {
  std::mt19937 random(5);
  TetState<double> t = random_tet(random);
  t.x[0] = {0.1, 0.2, 0.5};
  t.x[1] = {-1, -1, 0};
  t.x[2] = {0, 2, 0};
  t.x[3] = {2, -1, 0};
  ASSERT_GT(signed_volume(t.x), 0.0);
  const double target = 0.3 * signed_volume(t.x);
  const auto p = project_together(t, tet_gap(t.x, 1), target);
  EXPECT_LT(norm(moved_mass(t, p)), 1e-12);
  double height = 0.0;
  const TetGap<double> gap = tet_gap(t.x, 1);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(norm(cross(p.by[i], gap.normal)), 0.0, 1e-12);
    height += gap.w[i] * (t.x[i] + p.by[i]).z;
  }
  EXPECT_NEAR(height, 0.3 * 0.5, 1e-12);
}

TEST(PbdContact, FrictionKeepsTheMomentumForAllKindsOfTets) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 300; ++trial) {
    const TetState<double> t = random_tet(random);
    const int side_a = 1 + trial % 3;
    const TetGap<double> gap = tet_gap(t.x, side_a);
    double a = 0.0, b = 0.0;
    for (int i = 0; i < 4; ++i) (i < side_a ? a : b) += gap.w[i];
    EXPECT_NEAR(a, 1.0, 1e-12);
    EXPECT_NEAR(b, -1.0, 1e-12);
    const auto p = project_friction(t, gap, 0.3, 0.2, 0.05);
    EXPECT_TRUE(p.acts);
    EXPECT_LT(norm(moved_mass(t, p)), 1e-12);
  }
}

// What of the relative motion friction takes back.
double taken_back(const TetState<double>& t, const TetGap<double>& gap,
                  const AirProjection<double>& p, double& slip) {
  Vec3 before, by;
  for (int i = 0; i < 4; ++i) {
    before += gap.w[i] * (t.x[i] - t.before[i]);
    by += gap.w[i] * p.by[i];
  }
  before -= dot(before, gap.normal) * gap.normal;
  slip = norm(before);
  EXPECT_NEAR(dot(by, gap.normal), 0.0, 1e-12);
  return norm(by);
}

TEST(PbdContact, FrictionHoldsUpToTheStaticLimitAndThenTakesTheKineticOne) {
  std::mt19937 random(3);
  const double mu_static = 0.3, mu_kinetic = 0.2;
  int held = 0, slid = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const TetState<double> t = random_tet(random);
    const TetGap<double> gap = tet_gap(t.x, 1 + trial % 3);
    const double normal = 0.2 * (trial % 7);
    double slip = 0.0;
    const auto p = project_friction(t, gap, mu_static, mu_kinetic, normal);
    const double taken = taken_back(t, gap, p, slip);
    const bool holds = slip <= mu_static * normal;
    EXPECT_NEAR(taken, holds ? slip : mu_kinetic * normal, 1e-12);
    ++(holds ? held : slid);
  }
  EXPECT_GT(held, 20);
  EXPECT_GT(slid, 20);
}

TEST(PbdContact, AHeldVertexDoesNotMove) {
  std::mt19937 random(4);
  TetState<double> t = random_tet(random);
  t.inverse_mass[2] = 0.0;
  EXPECT_EQ(project_volume(t, 0.0).by[2], Vec3{});
  EXPECT_EQ(norm(project_friction(t, tet_gap(t.x, 1), 0.3, 0.2, 1.0).by[2]), 0.0);
}

SimulationOptions paper_options() {
  SimulationOptions options;
  options.contact.model = ContactModel::paper;
  options.balloon.name = "polyurethane";
  options.backend = Backend::cpu;
  options.inflation.control = InflationControl::pressure;
  options.inflation.peak_pressure_atm = 2.0;
  options.inflation.inflate_s = 0.75;
  options.inflation.hold_s = 0.1;
  options.inflation.deflate_s = 0.75;
  options.inflation.rest_s = 0.1;
  return options;
}

TEST(PbdContact, TheCurvesOfABalloonThatTouchesAndPartsAreThePapers) {
  const SimulationModel model = testing::matched_model(0.5, 0.62);
  double before = 0.0, rubbed = 0.0, drawn = 0.0, deflating = 0.0;
  bool touched = false;
  const SimulationSummary summary = simulate(model, paper_options(), [&](const auto& f) {
    touched = touched || f.contact.count > 0;
    if (!touched) before = std::max(before, f.contact.friction_delta_mm);
    rubbed = std::max(rubbed, f.contact.friction_delta_mm);
    if (f.phase == Phase::deflate) deflating = std::max(deflating, f.contact.viscous_delta_mm);
    drawn = std::max(drawn, f.contact.viscous_delta_mm);
    for (const Vec3& v : f.balloon) {
      ASSERT_TRUE(std::isfinite(v.x + v.y + v.z)) << f.frame;
      EXPECT_LT(std::hypot(v.x, v.y), 0.9) << f.frame;  // the wall holds it, somehow
    }
  });
  EXPECT_TRUE(touched);
  EXPECT_EQ(before, 0.0);
  EXPECT_GT(rubbed, 0.0);
  EXPECT_GT(deflating, 0.0);
  EXPECT_EQ(drawn, deflating);  // the film pulls most while they part
  EXPECT_NE(summary.warnings[0].find("does not converge"), std::string::npos);
}

TEST(ElementColors, TakeEachElementOnceAndNoVertexTwiceInAColour) {
  std::mt19937 random(6);
  std::uniform_int_distribution<int> u(0, 39);
  std::vector<int> vertices;
  while (vertices.size() < 400) {
    std::set<int> tet;
    while (tet.size() < 4) tet.insert(u(random));
    vertices.insert(vertices.end(), tet.begin(), tet.end());
  }
  const ElementColors colors = color_elements(vertices, 4, 40);
  std::vector<int> sorted = colors.order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t e = 0; e < sorted.size(); ++e) EXPECT_EQ(sorted[e], int(e));
  EXPECT_EQ(colors.order.size(), vertices.size() / 4);
  EXPECT_EQ(colors.begin.front(), 0);
  EXPECT_EQ(colors.begin.back(), int(colors.order.size()));
  const std::vector<int> ordered = in_order(colors, vertices, 4);
  for (std::size_t c = 0; c + 1 < colors.begin.size(); ++c) {
    std::set<int> met;
    for (int i = 4 * colors.begin[c]; i < 4 * colors.begin[c + 1]; ++i)
      EXPECT_TRUE(met.insert(ordered[std::size_t(i)]).second) << c;
  }
}

TEST(PbdContact, ATetThatStaysKeepsItsViscousItemInWhateverOrder) {
  PbdTets before, now;
  before.vertices = {0, 5, 6, 7, 1, 6, 7, 8, 2, 7, 8, 9};
  before.balloon_corners = {1, 1, 1};
  now.vertices = {2, 8, 9, 7, 3, 5, 6, 7, 0, 6, 7, 5};
  now.balloon_corners = {1, 1, 1};
  EXPECT_EQ(kept_items(before, {1, 1, 0}, now), (std::vector<char>{0, 0, 1}));
  EXPECT_EQ(kept_items({}, {}, now), (std::vector<char>{0, 0, 0}));
}

TEST(PbdContact, GivesTheSameBitsForOneAndThreeThreads) {
  const SimulationModel model = testing::matched_model(0.5, 0.62);
  SimulationOptions options = paper_options();
  options.inflation.deflate_s = 0.1;
  const Scene scene = make_scene(model, options);
  const double volume = balloon_volume(scene, scene.start);
  std::vector<std::vector<Vec3>> last(2);
  for (const int threads : {1, 3})
    make_cpu_solver(scene, options, Precision::single, threads)
        ->run(make_control(scene, options, volume),
              [&](int, const State& state) { last[threads == 1 ? 0 : 1] = state.x; });
  EXPECT_EQ(last[0], last[1]);
}

// Nothing searches bounds of motion then: a column goes as far as its equations say.
TEST(PbdContact, MovesTheColumnsOfALayeredWall) {
  SimulationModel model = testing::matched_model(0.5, 0.62);
  model.layered_wall = testing::extruded(model.wall, model.wall_fixed, 0.62, 0.189);
  SimulationOptions options = paper_options();
  options.inflation.inflate_s = 0.2;
  options.inflation.deflate_s = options.frame_s;
  int contacts = 0;
  double moved = 0.0;
  simulate(model, options, [&](const SimulationFrame& frame) {
    contacts = std::max(contacts, frame.contact.count);
    for (std::size_t v = 0; v < frame.wall.size(); ++v) {
      const double way = distance(frame.wall[v], model.wall.vertices[v]);
      ASSERT_TRUE(std::isfinite(way)) << frame.frame;
      moved = std::max(moved, way);
    }
  });
  EXPECT_GT(contacts, 0);
  EXPECT_GT(moved, 0.01);
}

TEST(PbdContact, NeedsAnAirMesh) {
  SimulationModel model = testing::matched_model(0.5, 0.62);
  model.air.clear();
  EXPECT_THROW(simulate(model, paper_options(), {}), InputError);
}

}  // namespace
}  // namespace angio::simulation::detail
