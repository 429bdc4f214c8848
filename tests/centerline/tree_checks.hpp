#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "centerline/centerline.hpp"
#include "testing/centerline/shapes.hpp"

namespace angio::test {

inline std::function<double(double)> constant(double radius) {
  return [radius](double) { return radius; };
}

/// A trunk along z and two unlike branches [mm].
inline std::vector<Tube> y_shape() {
  return {straight_tube({0, 0, 0}, {0, 0, 20}, constant(2.0)),
          straight_tube({0, 0, 20}, {8, 0, 38}, constant(1.5)),
          straight_tube({0, 0, 20}, {-9, 1, 36}, constant(1.2))};
}

inline centerline::CenterlineResult extract(const std::vector<Tube>& tubes, double noise = 0.0) {
  Volume<float> level_set = level_set_of(tubes, grid_around(tubes, 0.3, 1.5));
  if (noise > 0.0) add_noise(level_set, noise, 11);
  return centerline::extract_centerline(level_set, {});
}

/// What holds for every tree: arrays of one length, rising abscissae, tracts that cover each line
/// and share their borders, groups that mean the same points.
inline void expect_consistent(const CenterlineTree& tree) {
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    const CenterlinePath& path = tree.paths[p];
    const std::size_t count = path.points.size();
    EXPECT_EQ(path.id, int(p));
    ASSERT_EQ(path.inscribed_radius.size(), count);
    ASSERT_EQ(path.abscissa.size(), count);
    ASSERT_EQ(path.section_area.size(), count);
    ASSERT_EQ(path.equivalent_radius.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_TRUE(std::isfinite(path.section_area[i]));
      EXPECT_GT(path.inscribed_radius[i], 0.0);
      EXPECT_NEAR(units::kPi * path.equivalent_radius[i] * path.equivalent_radius[i],
                  path.section_area[i], 1e-9);
      if (i > 0) {
        EXPECT_GT(path.abscissa[i], path.abscissa[i - 1]);
      }
    }
    ASSERT_FALSE(path.tracts.empty());
    EXPECT_EQ(path.tracts.front().first_point, 0);
    EXPECT_EQ(path.tracts.back().last_point, int(count) - 1);
    for (std::size_t t = 0; t < path.tracts.size(); ++t) {
      EXPECT_EQ(path.tracts[t].tract_id, int(t));
      EXPECT_LT(path.tracts[t].first_point, path.tracts[t].last_point);
      if (t > 0) {
        EXPECT_EQ(path.tracts[t].first_point, path.tracts[t - 1].last_point);
      }
    }
    if (p > 0 && path.points.front() == tree.paths[p - 1].points.front()) {
      EXPECT_LE(path.abscissa.back(), tree.paths[p - 1].abscissa.back());
    }
  }
}

}  // namespace angio::test
