#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/vec3.hpp"
#include "viewer/detail/axis_letters.hpp"

namespace angio::viewer::detail {
namespace {

TEST(AxisLetters, LieApartHoweverTheAxesAreTurned) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int turn = 0; turn < 2000; ++turn) {
    Vec3 eye{unit(random), unit(random), unit(random)};
    if (turn < 27) eye = {double(turn % 3 - 1), double(turn / 3 % 3 - 1), double(turn / 9 - 1)};
    if (norm(eye) < 1e-3) continue;
    const Vec3 direction = normalized(eye);
    const Vec3 aside = std::abs(direction.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
    const Vec3 right = normalized(cross(direction, aside)), up = cross(right, direction);
    const auto letters = place_axis_letters({{{right.x, up.x}, {right.y, up.y}, {right.z, up.z}}});
    for (std::size_t a = 0; a < 3; ++a) {
      for (const double x : letters[a]) EXPECT_LE(std::abs(x), 1.4) << turn;
      for (std::size_t b = 0; b < a; ++b)
        EXPECT_GE(std::hypot(letters[a][0] - letters[b][0], letters[a][1] - letters[b][1]), 0.36)
            << turn;
    }
  }
}

TEST(AxisLetters, StandBeyondTheTipsWhereThereIsRoom) {
  const auto letters = place_axis_letters({{{1.0, 0.0}, {0.0, 0.0}, {0.0, 1.0}}});
  EXPECT_NEAR(letters[0][0], 1.25, 1e-9);
  EXPECT_NEAR(letters[2][1], 1.25, 1e-9);
  EXPECT_LT(letters[1][0], 0.0);  // between none of the others
  EXPECT_LT(letters[1][1], 0.0);
}

}  // namespace
}  // namespace angio::viewer::detail
