#include <gtest/gtest.h>

#include "simulation/contact/adhesion.hpp"

/// The film between two wet surfaces.
namespace angio::simulation::detail {
namespace {

const Adhesion<double> kFilm{2500.0, 0.03, 0.06};

TEST(Film, TractionAndStiffnessAreTheSlopesOfTheEnergy) {
  const double h = 1e-7;
  for (const double g : {0.031, 0.035, 0.04, 0.05, 0.059}) {
    const auto at = film_pull(kFilm, g), up = film_pull(kFilm, g + h),
               down = film_pull(kFilm, g - h);
    EXPECT_NEAR(at.traction, (up.energy - down.energy) / (2 * h), 1e-5 * kFilm.traction);
    EXPECT_NEAR(at.stiffness, (up.traction - down.traction) / (2 * h), 1e-5 * kFilm.traction / h);
  }
}

TEST(Film, PullsOnlyBetweenItsGapsAndNeverMoreThanItsTraction) {
  double most = 0.0;
  for (double g = 0.0; g < 0.1; g += 1e-5) {
    const double t = film_pull(kFilm, g).traction;
    EXPECT_GE(t, 0.0);
    if (g <= kFilm.gap_1 || g >= kFilm.gap_2) {
      EXPECT_EQ(t, 0.0);
    }
    most = std::max(most, t);
  }
  EXPECT_NEAR(most, kFilm.traction, 1e-6 * kFilm.traction);
}

TEST(Film, PartingCostsTheWorkOfTheLaw) {
  double work = 0.0;
  const double step = 1e-6;
  for (double g = kFilm.gap_1 + 0.5 * step; g < kFilm.gap_2; g += step)
    work += step * film_pull(kFilm, g).traction;
  const double law = 9.0 / 16.0 * kFilm.traction * (kFilm.gap_2 - kFilm.gap_1);
  EXPECT_NEAR(work, law, 1e-6 * law);
  EXPECT_NEAR(film_pull(kFilm, 1.0).energy, law, 1e-12 * law);
}

TEST(Film, FormsAtFirstTouchAndBreaksForGoodAtTheSecondGap) {
  bool wet = false;
  wet = stays_wet(kFilm, wet, 0.04);
  EXPECT_FALSE(wet);  // near, but never touched
  wet = stays_wet(kFilm, wet, 0.02);
  EXPECT_TRUE(wet);
  wet = stays_wet(kFilm, wet, 0.05);
  EXPECT_TRUE(wet);
  wet = stays_wet(kFilm, wet, 0.061);
  EXPECT_FALSE(wet);
  wet = stays_wet(kFilm, wet, 0.05);
  EXPECT_FALSE(wet);  // until touched again
  EXPECT_TRUE(stays_wet(kFilm, wet, 0.03));
}

}  // namespace
}  // namespace angio::simulation::detail
