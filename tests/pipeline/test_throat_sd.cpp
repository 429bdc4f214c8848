#include <gtest/gtest.h>

#include <limits>

#include "pipeline/case/throat_sd.hpp"

namespace angio::pipeline {
namespace {

/// Two lines along x, 10 mm apart, of 1 mm radius; the sd of the first grows by 0.01 mm a mm.
formats::PolylineData fitted_lines() {
  formats::PolylineData data;
  DataArray radius, sd;
  radius.name = "TubeRadius";
  sd.name = "RadiusStandardDeviation";
  for (int line = 0; line < 2; ++line) {
    data.lines.emplace_back();
    for (int n = 0; n <= 10; ++n) {
      data.lines.back().push_back(int(data.points.size()));
      data.points.push_back({2.0 * n, 10.0 * line, 0.0});
      radius.values.push_back(1.0);
      sd.values.push_back(line == 0 ? 0.02 * n : 0.5);
    }
  }
  data.point_arrays = {radius, sd};
  return data;
}

TEST(ThroatSd, IsTwiceTheRadiusAtThePlaceOfTheLinesNearestToTheThroat) {
  const formats::PolylineData fitted = fitted_lines();
  for (const double x : {0.0, 4.0, 7.3, 20.0})
    EXPECT_NEAR(fitted_diameter_sd(fitted, {x, 0.4, -0.3}).value(), 2.0 * 0.01 * x, 1e-12);
  EXPECT_NEAR(fitted_diameter_sd(fitted, {7.3, 9.5, 0.0}).value(), 1.0, 1e-12);
}

TEST(ThroatSd, IsNotKnownOutsideTheFittedVessels) {
  EXPECT_FALSE(fitted_diameter_sd(fitted_lines(), {4.0, 1.2, 0.0}));
  EXPECT_FALSE(fitted_diameter_sd(fitted_lines(), {22.0, 0.0, 0.0}));
}

TEST(ThroatSd, IsNotKnownWhereTheFitGaveNoNumber) {
  for (const double none :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    formats::PolylineData fitted = fitted_lines();
    fitted.point_arrays[1].values[3] = none;
    EXPECT_FALSE(fitted_diameter_sd(fitted, {6.0, 0.0, 0.0}));
    EXPECT_TRUE(fitted_diameter_sd(fitted, {16.0, 0.0, 0.0}));
  }
}

}  // namespace
}  // namespace angio::pipeline
