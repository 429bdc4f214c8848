#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/error.hpp"
#include "simulation/wall.hpp"
#include "testing/simulation/thick_tubes.hpp"

namespace angio::simulation {
namespace {

using testing::round_tube;

std::string complaint(const LayeredWall& wall, const WallOptions& options = {}) {
  try {
    prestress_wall(wall, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(BadWall, IsRefusedWithItsElementNamed) {
  const LayeredWall good = make_tube_wall(round_tube(1.2, 1.75, 8, 2, 1.0));
  EXPECT_EQ(complaint(good), "");

  LayeredWall bad = good;
  std::swap(bad.wedges[5][1], bad.wedges[5][2]);
  std::swap(bad.wedges[5][4], bad.wedges[5][5]);
  EXPECT_TRUE(says(complaint(bad), "wedge 5 (layer 0, intima) is inside out")) << complaint(bad);

  bad = good;
  const Wedge& thin = bad.wedges[40];
  bad.vertices[static_cast<std::size_t>(thin[3])] = bad.vertices[static_cast<std::size_t>(thin[0])];
  EXPECT_TRUE(says(complaint(bad), "has no thickness at vertex")) << complaint(bad);

  bad = good;
  bad.vertices[7].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(says(complaint(bad), "vertex 7 ")) << complaint(bad);

  bad = good;
  bad.vertices.push_back({9, 9, 9});
  bad.fixed.push_back(0);
  EXPECT_TRUE(says(complaint(bad), "in pieces: vertex " + std::to_string(good.vertices.size())))
      << complaint(bad);

  bad = good;
  bad.wedges[3][4] = 12345;
  EXPECT_TRUE(says(complaint(bad), "wedge 3 ") && says(complaint(bad), "12345"));

  bad = good;
  bad.axial[9] = {0, 0, 0};
  EXPECT_TRUE(says(complaint(bad), "wedge 9 "));

  bad = good;
  bad.fixed.assign(bad.fixed.size(), 0);
  WallOptions loose;
  loose.foundation_kpa_per_mm = 0.0;
  EXPECT_TRUE(says(complaint(bad, loose), "nothing holds"));

  WallOptions nonsense;
  nonsense.materials[1].shear_kpa = -3.0;
  EXPECT_TRUE(says(complaint(good, nonsense), "wall.media.shear_kpa"));
  nonsense = {};
  nonsense.materials[3].bulk_kpa = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(says(complaint(good, nonsense), "wall.plaque.bulk_kpa"));
}

TEST(WallOptions, DefaultsAreValid) { EXPECT_NO_THROW(WallOptions{}.validate()); }

}  // namespace
}  // namespace angio::simulation
