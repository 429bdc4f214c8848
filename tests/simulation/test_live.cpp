#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulation/live.hpp"
#include "simulation/run/wire_track.hpp"
#include "testing/simulation/models.hpp"
#include "testing/simulation/small_stenosis.hpp"

namespace angio::simulation {
namespace {

using detail::WireTrack;

std::vector<Vec3> arc(double radius, int count, double angle) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double a = angle * i / (count - 1);
    points.push_back({radius * std::cos(a), radius * std::sin(a), 0.0});
  }
  return points;
}

TEST(WireTrack, CarriesRigidlyAlongAStraightWireAndBeyondIt) {
  const WireTrack track({{0, 0, -3}, {0, 0, 1}, {0, 0, 1}, {0, 0, 5}});
  EXPECT_DOUBLE_EQ(track.length_mm(), 8.0);
  for (const Vec3& p : {Vec3{1, 2, 0}, Vec3{-0.5, 0, 4.9}, Vec3{0, 0.1, -6}})
    for (const double by : {0.3, -2.5, 9.0})
      EXPECT_LT(norm(track.carried(p, by) - (p + Vec3{0, 0, by})), 1e-12);
}

TEST(WireTrack, TurnsWithACircle) {
  constexpr double kRadius = 20.0;
  const WireTrack track(arc(kRadius, 400, 1.5));
  const Vec3 place{kRadius + 0.7, 0.0, 0.4};  // beside the start
  const Vec3 carried = track.carried(place, kRadius * 0.5);
  // By half a radian, at the same distance from the axis of the circle and above its plane.
  EXPECT_NEAR(std::hypot(carried.x, carried.y), kRadius + 0.7, 2e-3);
  EXPECT_NEAR(std::atan2(carried.y, carried.x), 0.5, 2e-3);
  EXPECT_NEAR(carried.z, 0.4, 1e-9);
  EXPECT_LT(norm(track.carried(carried, -kRadius * 0.5) - place), 5e-3);
}

TEST(WireTrack, OfASinglePointCarriesNothing) {
  const WireTrack track({{1, 1, 1}});
  EXPECT_EQ(track.carried({2, 2, 2}, 3.0), (Vec3{2, 2, 2}));
}

SimulationOptions quick_on_a_wire() {
  SimulationOptions options;
  options.frame_s = 0.04;
  options.inflation.inflate_s = 1.2;
  options.inflation.deflate_s = 1.0;
  options.inflation.peak_pressure_atm = 6.0;
  return options;
}

SimulationModel on_a_wire() {
  SimulationModel model = testing::make_model(testing::small_stenosis());
  model.guidewire_before = {{0, 0, -10}};
  model.guidewire_behind = {{0, 0, 8}};
  return model;
}

double mean_z(const std::vector<Vec3>& points) {
  double sum = 0.0;
  for (const Vec3& p : points) sum += p.z;
  return sum / double(points.size());
}

TEST(LiveSimulation, ReachesThePressureThatIsAskedForAndNoMore) {
  LiveSimulation live(on_a_wire(), quick_on_a_wire());
  double before = live.frame().balloon_volume_mm3;
  EXPECT_NEAR(live.frame().pressure_atm, 0.0, 1e-9);
  for (int i = 0; i < 60; ++i) {
    const SimulationFrame& frame = live.step({3.0, 0.0});
    EXPECT_LE(frame.pressure_atm, 3.0 + 1e-3);
    EXPECT_GE(frame.balloon_volume_mm3, before - 0.02 * before);
    EXPECT_EQ(frame.contact.max_penetration_mm, 0.0);
    before = frame.balloon_volume_mm3;
  }
  EXPECT_NEAR(live.frame().pressure_atm, 3.0, 0.03);
  EXPECT_GT(live.frame().contact.count, 0);
  EXPECT_EQ(live.frame().frame, 60);
  EXPECT_NEAR(live.frame().time_s, 60 * 0.04, 1e-9);
}

TEST(LiveSimulation, HoldsAndLetsDown) {
  LiveSimulation live(on_a_wire(), quick_on_a_wire());
  const double start = live.frame().balloon_volume_mm3;
  for (int i = 0; i < 60; ++i) live.step({3.0, 0.0});
  const double full = live.frame().balloon_volume_mm3;
  EXPECT_GT(full, 2.0 * start);
  for (int i = 0; i < 80; ++i) {
    const SimulationFrame& frame = live.step({1.0, 0.0});
    EXPECT_GE(frame.pressure_atm, 1.0 - 1e-3) << "the valve holds what is asked for";
  }
  EXPECT_NEAR(live.frame().pressure_atm, 1.0, 0.05);
  for (int i = 0; i < 120; ++i) live.step({0.0, 0.0});
  EXPECT_LT(live.frame().balloon_volume_mm3, 0.5 * full);
}

TEST(LiveSimulation, MovesTheDeflatedBalloonRigidlyOnAStraightWire) {
  LiveSimulation live(on_a_wire(), quick_on_a_wire());
  const std::vector<Vec3> start = live.frame().balloon;
  EXPECT_NEAR(live.least_place_mm(), -5.5, 1e-9);  // from the wire's end to the balloon's
  EXPECT_NEAR(live.most_place_mm(), 3.5, 1e-9);
  for (int i = 0; i < 20; ++i) live.step({0.0, 1.5});
  EXPECT_NEAR(live.place_mm(), 1.5, 1e-12);
  EXPECT_FALSE(live.is_stuck());
  EXPECT_NEAR(mean_z(live.frame().balloon) - mean_z(start), 1.5, 0.02);
  for (int i = 0; i < 20; ++i) live.step({0.0, -100.0});
  EXPECT_GE(live.place_mm(), live.least_place_mm() - 1e-12) << "no further than the wire";
}

TEST(LiveSimulation, IsStuckWhereTheFullBalloonFillsTheThroat) {
  LiveSimulation live(on_a_wire(), quick_on_a_wire());
  for (int i = 0; i < 80; ++i) live.step({6.0, 0.0});
  bool was_stuck = false;
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(live.step({6.0, 3.0}).contact.max_penetration_mm, 0.0);
    was_stuck = was_stuck || live.is_stuck();
  }
  EXPECT_TRUE(was_stuck);
  EXPECT_LT(live.place_mm(), 3.0);
}

TEST(LiveSimulation, GivesTheSameFramesEachTime) {
  LiveSimulation a(on_a_wire(), quick_on_a_wire()), b(on_a_wire(), quick_on_a_wire());
  for (int i = 0; i < 30; ++i) {
    const LiveAim aim{i < 20 ? 2.0 : 0.5, i < 10 ? 0.0 : 0.3};
    a.step(aim);
    b.step(aim);
  }
  EXPECT_EQ(a.frame().balloon, b.frame().balloon);
  EXPECT_EQ(a.frame().wall, b.frame().wall);
}

}  // namespace
}  // namespace angio::simulation
