#include <gtest/gtest.h>

#include "testing/simulation/sliding.hpp"

/// Coulomb's laws, for all three ways in which an air tet's primitives touch.
namespace angio::simulation {
namespace {

using testing::Slide;
using testing::SlideSetup;
using testing::Touch;

class Friction : public ::testing::TestWithParam<Touch> {
 protected:
  static SlideSetup setup() {
    SlideSetup s;
    s.touch = GetParam();
    return s;
  }
};

TEST_P(Friction, ABlockStaysOnAnInclineUpToCoulombsAngle) {
  const double coulomb = std::atan(setup().mu_static);
  EXPECT_NEAR(testing::angle_of_repose(setup()), coulomb, 0.01 * coulomb);
}

TEST_P(Friction, ASlidingBlockGainsSpeedByWhatKineticFrictionLeaves) {
  SlideSetup s = setup();
  s.dt = 2.5e-4;
  const double angle = 1.5 * std::atan(s.mu_static), time = 0.1;
  s.acceleration = testing::on_incline(angle);
  Slide slide(s);
  const double start = slide.block().x;
  slide.run(time);
  const double law =
      0.5 * testing::kGravity * (std::sin(angle) - s.mu_kinetic * std::cos(angle)) * time * time;
  EXPECT_NEAR(slide.block().x - start, law, 0.01 * law);
}

TEST_P(Friction, APushedBlockSlidesAsFarAsItsEnergyLasts) {
  SlideSetup s = setup();
  s.dt = 1e-4;
  s.acceleration = {0.0, 0.0, -testing::kGravity};
  s.velocity = {60.0, 80.0, 0.0};
  Slide slide(s);
  const Vec3 start = slide.block();
  slide.run(0.1);
  const Vec3 gone = slide.block() - start;
  const double law = 100.0 * 100.0 / (2.0 * s.mu_kinetic * testing::kGravity);
  EXPECT_NEAR(std::hypot(gone.x, gone.y), law, 0.01 * law);
  EXPECT_NEAR(gone.y / gone.x, 80.0 / 60.0, 1e-6);
  EXPECT_LT(norm(slide.speed()), 0.02);
}

TEST_P(Friction, KeepsTheMomentumOfTwoFreeBodies) {
  SlideSetup s = setup();
  s.base_is_free = true;
  s.velocity = {20.0, -10.0, -5.0};  // down on the base
  Slide slide(s);
  const Vec3 before = slide.momentum();
  const Vec3 speed = slide.speed();
  slide.run(0.05);
  EXPECT_LT(norm(slide.momentum() - before), 1e-6 * norm(before));
  const Vec3 gained = slide.speed() - speed;
  EXPECT_GT(gained.z, 2.0);  // they have pushed, and rubbed
  EXPECT_NEAR(std::hypot(gained.x, gained.y), s.mu_kinetic * gained.z, 1e-3 * gained.z);
}

INSTANTIATE_TEST_SUITE_P(Touches, Friction,
                         ::testing::Values(Touch::vertex_on_face, Touch::edge_on_edge,
                                           Touch::face_on_vertex));

}  // namespace
}  // namespace angio::simulation
