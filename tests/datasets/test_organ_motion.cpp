#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "datasets/detail/organ_motion.hpp"

namespace angio::datasets::detail {
namespace {

TEST(OrganMotion, OfTheHeartIsSmoothAndComesBack) {
  EXPECT_NEAR(heart_excursion(kRestingPhase), 0.0, 1e-12);
  EXPECT_NEAR(heart_excursion(0.35), 1.0, 1e-12);
  double fastest = 0.0;
  for (double phase = 0.0; phase < 1.0; phase += 1e-3) {
    const double excursion = heart_excursion(phase);
    EXPECT_GE(excursion, 0.0);
    EXPECT_LE(excursion, 1.0);
    EXPECT_NEAR(heart_excursion(phase + 1.0), excursion, 1e-9);
    const auto slope = [](double at) {
      return (heart_excursion(at + 1e-5) - heart_excursion(at - 1e-5)) / 2e-5;
    };
    EXPECT_NEAR(slope(phase), slope(phase + 1e-4), 0.05) << phase;  // no kink
    fastest = std::max(fastest, std::abs(slope(phase)));
  }
  EXPECT_LT(fastest, 10.0);
}

TEST(OrganMotion, OfABreathRestsBreathedOut) {
  EXPECT_NEAR(breath_excursion(0.0, 15.0), 0.0, 1e-12);
  EXPECT_NEAR(breath_excursion(2.0, 15.0), 1.0, 1e-12);
  EXPECT_NEAR(breath_excursion(4.5, 15.0), breath_excursion(0.5, 15.0), 1e-12);
  EXPECT_LT(breath_excursion(0.8, 15.0), 0.1);
}

TEST(OrganMotion, HasBeatsOfTheRateThatIsAskedFor) {
  const std::vector<double> beats = r_waves(75.0, 0.0, 60.0, 3);
  EXPECT_LE(beats.front(), 0.0);
  EXPECT_GT(beats.back(), 60.0);
  EXPECT_NEAR(double(beats.size() - 1) / (beats.back() - beats.front()), 1.25, 0.02);
  EXPECT_TRUE(std::is_sorted(beats.begin(), beats.end()));
  EXPECT_NE(beats, r_waves(75.0, 0.0, 60.0, 4));
  EXPECT_NEAR(cardiac_phase({1.0, 2.0, 4.0}, 2.5), 0.25, 1e-12);
}

TriangleMesh cross_of_points() {
  TriangleMesh mesh;
  mesh.vertices = {{20, 0, 0}, {-20, 0, 0}, {0, 20, 0}, {0, -20, 0}, {0, 0, 20}, {0, 0, -20}};
  return mesh;
}

TEST(OrganMotion, GoesAsFarAsIsAskedForAndNoFarther) {
  double longest = 0.0;
  for (const Vec3& way : systolic_ways(cross_of_points(), 5.0))
    longest = std::max(longest, norm(way));
  EXPECT_NEAR(longest, 5.0, 1e-9);
  EXPECT_THROW(systolic_ways(cross_of_points(), 20.0), OptionError);
}

TEST(OrganMotion, LeavesTheTruthWhereTheHeartRests) {
  RotationalRunOptions run;
  run.frames = 133;
  run.heartbeat_mm = 8.0;
  run.breathing_mm = 5.0;
  run.inflow_s = 1.0;
  const RunMotion motion = plan_motion(run, 1);
  ASSERT_EQ(motion.cardiac_phases.size(), 133u);
  for (std::size_t f = 0; f < 133; ++f) {
    if (std::abs(motion.cardiac_phases[f] - kRestingPhase) < 0.05) {
      EXPECT_LT(std::abs(motion.heart_excursions[f]), 0.03);
    }
    EXPECT_NEAR(motion.filled_parts[f], std::min(1.0, 0.033 * double(f)), 1e-12);
    EXPECT_LE(norm(motion.breathing_shifts_mm[f]), 5.0 + 1e-9);
  }
  // Each R wave's frame begins a beat.
  for (const int frame : motion.r_wave_frames) {
    const double phase = motion.cardiac_phases[std::size_t(frame)];
    EXPECT_LT(std::min(phase, 1.0 - phase), 0.5 * 33.0 / (60000.0 / 70.0) * 1.3);
  }
  EXPECT_EQ(motion.r_wave_frames.size(), 5u);
}

TEST(OrganMotion, MovesASurfaceByHeartAndBreath) {
  const TriangleMesh mesh = cross_of_points();
  const std::vector<Vec3> ways = systolic_ways(mesh, 4.0);
  RunMotion motion;
  motion.heart_excursions = {0.5};
  motion.breathing_shifts_mm = {{0.0, 0.0, -3.0}};
  const TriangleMesh moved = moved_surface(mesh, ways, motion, 0);
  for (std::size_t v = 0; v < ways.size(); ++v)
    EXPECT_NEAR(norm(moved.vertices[v] - (mesh.vertices[v] + 0.5 * ways[v] + Vec3{0.0, 0.0, -3.0})),
                0.0, 1e-12);
}

}  // namespace
}  // namespace angio::datasets::detail
