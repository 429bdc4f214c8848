#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/materials/material.hpp"
#include "testing/simulation/charts.hpp"

namespace angio::simulation::detail {
namespace {

using testing::Charted;

BalloonMaterial material_of(const Charted& balloon) {
  BalloonMaterial material;
  material.name = balloon.material;
  material.wall_mm = balloon.wall_mm;
  material.chart = balloon.chart;
  return material;
}

// Psi of a tube's wall at stretches l1 around and l2 along.
double energy(const MembraneLaw<double>& law, double l1, double l2) {
  EnergyDensity<double> e = plain_energy(law.base, l1 * l1 + l2 * l2, l1 * l1 * l2 * l2);
  add_fibres(law.fibre, l1 * l1, e);
  return e.value;
}

// Diameter of the closed free tube under a pressure: the least of w - p V per wall volume, by
// descending coordinate-wise with differences. It knows nothing of how the law was made.
double tube_diameter(const MembraneLaw<double>& law, double rest_mm, double wall_mm,
                     double pressure_atm) {
  const double load = units::pascal_from_atm(pressure_atm) * 0.5 * rest_mm / wall_mm;
  const auto potential = [&](double l1, double l2) {
    return energy(law, l1, l2) - 0.5 * load * l1 * l1 * l2;
  };
  const auto along = [&](double l1) {
    double low = 0.5, high = 3.0;
    for (int i = 0; i < 80; ++i) {
      const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
      (potential(l1, a) < potential(l1, b) ? high : low) =
          potential(l1, a) < potential(l1, b) ? b : a;
    }
    return 0.5 * (low + high);
  };
  double low = 0.9, high = 2.0;
  for (int i = 0; i < 80; ++i) {
    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    if (potential(a, along(a)) < potential(b, along(b)))
      high = b;
    else
      low = a;
  }
  return 0.5 * (low + high) * rest_mm;
}

class ChartLaw : public ::testing::TestWithParam<Charted> {};

TEST_P(ChartLaw, AClosedFreeTubeReproducesEveryPoint) {
  const MembraneLaw<double> law = membrane_law(material_of(GetParam()));
  const double rest = rest_diameter_mm(GetParam().chart);
  for (const ChartPoint& point : GetParam().chart)
    EXPECT_NEAR(tube_diameter(law, rest, GetParam().wall_mm, point.pressure_atm), point.diameter_mm,
                2e-5 * point.diameter_mm)
        << point.pressure_atm;
}

TEST_P(ChartLaw, FibresOnlyPullAndAreConvex) {
  const FibreLaw<double> law = membrane_law(material_of(GetParam())).fibre;
  double last = 0.0;
  for (double i4 = 0.9; i4 < 3.0; i4 += 1e-3) {
    EnergyDensity<double> e;
    add_fibres(law, i4, e);
    EXPECT_GE(e.d4, last * (1.0 - 1e-12)) << i4;
    EXPECT_GE(e.d44, -1e-6 * law.curvature[law.count - 1]) << i4;
    last = e.d4;
  }
}

TEST_P(ChartLaw, TheBaseIsNoStifferThanItsMaterial) {
  const BalloonMaterial material = material_of(GetParam());
  const MembraneLaw<double> law = membrane_law(material);
  EXPECT_GT(law.base.c1, 0.0);
  EXPECT_LE(law.base.c1, moduli(material).c1);
}

TEST_P(ChartLaw, TheDiameterRisesBetweenAndPastThePoints) {
  const MembraneLaw<double> law = membrane_law(material_of(GetParam()));
  const double rest = rest_diameter_mm(GetParam().chart);
  const double most = 1.3 * GetParam().chart.back().pressure_atm;
  double last = rest * (1.0 - 1e-6);
  for (int k = 0; k <= 20; ++k) {
    const double d = tube_diameter(law, rest, GetParam().wall_mm, most * k / 20.0);
    EXPECT_GE(d, last) << most * k / 20.0;
    // 1.3 times the last pressure: a straight line would give 1.3 times the growth.
    if (k == 20) {
      EXPECT_LT(d, rest + 1.6 * (GetParam().chart.back().diameter_mm - rest));
    }
    last = d;
  }
}

INSTANTIATE_TEST_SUITE_P(Balloons, ChartLaw, ::testing::ValuesIn(testing::charted_balloons()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Chart, RestDiameterIsTheLineThroughTheFirstTwoPointsOrThePointAtZero) {
  EXPECT_NEAR(rest_diameter_mm(std::vector<ChartPoint>{{4, 2.85}, {6, 2.93}, {8, 3.0}}), 2.69,
              1e-12);
  EXPECT_NEAR(rest_diameter_mm(std::vector<ChartPoint>{{0, 2.7}, {6, 2.93}}), 2.7, 1e-12);
  EXPECT_THROW(rest_diameter_mm(std::vector<ChartPoint>{{4, 2.0}, {5, 3.0}}), InputError);
}

TEST(Chart, IsStraightBetweenItsPointsAndSilentOutside) {
  const std::vector<ChartPoint> chart{{4, 2.85}, {6, 2.93}, {8, 3.0}};
  EXPECT_NEAR(chart_diameter_mm(chart, 7.0), 2.965, 1e-12);
  EXPECT_NEAR(chart_diameter_mm(chart, 4.0), 2.85, 1e-12);
  EXPECT_NEAR(chart_diameter_mm(chart, 8.0), 3.0, 1e-12);
  EXPECT_TRUE(std::isnan(chart_diameter_mm(chart, 3.9)));
  EXPECT_TRUE(std::isnan(chart_diameter_mm(chart, 8.1)));
}

TEST(Chart, NamesTheWrongPoint) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<ChartPoint>& chart : {std::vector<ChartPoint>{{4, 2.85}, {6, 2.80}},
                                               {{4, 2.85}, {4, 2.9}},
                                               {{4, 2.85}, {6, nan}},
                                               {{-1, 2.85}, {6, 2.9}}}) {
    try {
      validate_chart(chart, "mine");
      FAIL();
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("\"mine\" is wrong at point"), std::string::npos);
    }
  }
  EXPECT_THROW(validate_chart({{4, 2.85}}, "mine"), InputError);
}

TEST(HoopFibres, GoAroundAStraightAndABentBalloon) {
  // A triangle of a cylinder's wall around the z axis, and one around a bent line.
  const std::vector<Vec3> rest{{1, 0, 0}, {1, 0.1, 0}, {1, 0, 0.1}, {-1, 0, 3}, {-1, 0.1, -3}};
  const auto straight = hoop_fibres({{0, 1, 2}}, rest, {{0, 0, -5}, {0, 0, 5}});
  EXPECT_NEAR(std::abs(straight[0].y), 1.0, 1e-12);
  const auto bent = hoop_fibres({{0, 1, 2}}, rest, {{0, -5, 0}, {0, 5, 0}, {9, 5, 0}});
  EXPECT_NEAR(std::abs(bent[0].z), 1.0, 1e-12);
  const auto by_shape = hoop_fibres({{0, 1, 2}}, rest, {});
  EXPECT_LT(std::abs(by_shape[0].z), 0.3);
  EXPECT_EQ(hoop_fibres({{0, 1, 2}}, rest, {{-5, 0, 0}, {5, 0, 0}})[0], Vec3{});
}

}  // namespace
}  // namespace angio::simulation::detail
