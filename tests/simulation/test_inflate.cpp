#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/inflate.hpp"
#include "testing/simulation/charts.hpp"
#include "testing/simulation/closed_forms.hpp"

namespace angio::simulation {
namespace {

using testing::closed_tube;
using testing::TubeState;

constexpr double kRadius = 1.5, kLength = 15.0, kWall = 0.02;

FreeBalloon rubber(BalloonEnds ends) {
  FreeBalloon balloon;
  balloon.radius_mm = kRadius;
  balloon.length_mm = kLength;
  balloon.material.name = "polyurethane";
  balloon.material.wall_mm = kWall;
  balloon.ends = ends;
  return balloon;
}

double atm_of_load(double load_mpa) {  // p R / H
  return units::atm_from_pascal(units::pascal_from_megapascal(load_mpa) * kWall / kRadius);
}

InflateOptions at_pressures(std::vector<double> pressures_atm) {
  InflateOptions options;
  options.pressures_atm = std::move(pressures_atm);
  return options;
}

InflateOptions at_volumes(std::vector<double> volumes_mm3) {
  InflateOptions options;
  options.volumes_mm3 = std::move(volumes_mm3);
  return options;
}

InflateOptions at_loads(const std::vector<double>& loads_mpa) {
  InflateOptions options;
  for (const double load : loads_mpa) options.pressures_atm.push_back(atm_of_load(load));
  return options;
}

TEST(Inflate, ACapsuleFollowsTheClosedFreeTube) {
  std::vector<double> loads;
  const std::vector<double> stretches{1.05, 1.1, 1.2, 1.3};
  for (const double l : stretches) loads.push_back(closed_tube(l).load_mpa);
  const auto points = inflate(rubber(BalloonEnds::hemispheres), at_loads(loads));
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(points[i].converged);
    EXPECT_NEAR(points[i].diameter_mm / (2.0 * kRadius), stretches[i], 1e-3 * stretches[i]);
    EXPECT_NEAR(points[i].pressure_atm, atm_of_load(loads[i]), 1e-9);
    const TubeState exact = closed_tube(stretches[i]);
    EXPECT_NEAR(points[i].wall_mm, kWall / (exact.around * exact.along), 2e-3 * kWall);
    // The ends hold the shoulders: the whole is no longer, and no wider, than the middle would be.
    EXPECT_NEAR(points[i].length_mm, kLength * exact.along, 0.01 * kLength);
  }
}

TEST(Inflate, APieceOfTubeFollowsItsClosedFormAtEveryStretch) {
  const std::vector<double> stretches{1.02, 1.1, 1.3, 1.6, 2.0, 2.5, 3.0};
  InflateOptions options;
  for (const double l : stretches)
    options.volumes_mm3.push_back(units::kPi * kRadius * kRadius * kLength * l * l *
                                  closed_tube(l).along);
  const auto points = inflate(rubber(BalloonEnds::tube), options);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TubeState exact = closed_tube(stretches[i]);
    ASSERT_TRUE(points[i].converged) << stretches[i];
    EXPECT_NEAR(points[i].diameter_mm / (2.0 * kRadius), exact.around, 1e-3 * exact.around);
    EXPECT_NEAR(points[i].length_mm / kLength, exact.along, 1e-3);
    EXPECT_NEAR(points[i].pressure_atm, atm_of_load(exact.load_mpa),
                2e-3 * atm_of_load(exact.load_mpa));
    EXPECT_NEAR(points[i].volume_mm3, options.volumes_mm3[i], 1e-6 * options.volumes_mm3[i]);
    EXPECT_NEAR(points[i].stress_mpa,  // p r / h
                units::pascal_from_atm(points[i].pressure_atm) * 0.5e-6 * points[i].diameter_mm /
                    points[i].wall_mm,
                2e-3 * points[i].stress_mpa);
  }
}

TEST(Inflate, TheClosedTubeHasItsLimitPointUnderVolumeControl) {
  InflateOptions options;
  for (double l = 2.2; l < 2.9; l += 0.05)
    options.volumes_mm3.push_back(units::kPi * kRadius * kRadius * kLength * l * l * 0.83);
  double most = 0.0, stretch = 0.0, last = 0.0;
  for (const InflationPoint& point : inflate(rubber(BalloonEnds::tube), options)) {
    ASSERT_TRUE(point.converged);
    last = point.pressure_atm;
    if (last <= most) continue;
    most = last;
    stretch = point.diameter_mm / (2.0 * kRadius);
  }
  EXPECT_NEAR(most, atm_of_load(8.253), 0.005 * most);
  EXPECT_NEAR(stretch, 2.5, 0.1);
  EXPECT_LT(last, most);  // past it the pressure falls
}

TEST(Inflate, NoStateOfRestIsFoundUnderMoreThanTheLimitPressure) {
  const auto points = inflate(rubber(BalloonEnds::tube), at_loads({9.0, 4.751, 8.0}));
  EXPECT_FALSE(points[0].converged);
  EXPECT_TRUE(points[1].converged);
  EXPECT_TRUE(points[2].converged);
  EXPECT_NEAR(points[1].diameter_mm, 1.2 * 2.0 * kRadius, 1e-3 * 2.0 * kRadius);
  EXPECT_LE(points[0].pressure_atm, atm_of_load(8.253) * 1.005);  // the last state before it
  EXPECT_GE(points[0].pressure_atm, atm_of_load(8.0));
}

TEST(Inflate, ATubeOfFixedLengthFollowsItsClosedForm) {
  const std::vector<double> stretches{1.05, 1.1, 1.3, 1.7, 2.0, 2.4};
  std::vector<double> loads;
  for (const double l : stretches)
    loads.push_back(2.0 * (testing::kC1 + testing::kC2) * (1.0 - std::pow(l, -4)));
  const auto points = inflate(rubber(BalloonEnds::fixed_length), at_loads(loads));
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(points[i].converged);
    EXPECT_NEAR(points[i].diameter_mm / (2.0 * kRadius), stretches[i], 2e-3 * stretches[i]);
    EXPECT_NEAR(points[i].length_mm, kLength, 1e-9);
  }
}

TEST(Inflate, AStiffBalloonGrowsAsTheLinearElasticCylinder) {
  FreeBalloon balloon;  // dD / D = p R (1 - nu / 2) / (E t) for small strains
  const auto points = inflate(balloon, at_pressures({0.5}));
  const double strain = units::pascal_from_atm(0.5) * 1.5 * 0.75 / (900e6 * 0.02);
  EXPECT_NEAR(points[0].diameter_mm / 3.0 - 1.0, strain, 0.01 * strain);
}

class ChartedBalloon : public ::testing::TestWithParam<testing::Charted> {};

TEST_P(ChartedBalloon, FreeInflationReproducesItsChart) {
  FreeBalloon balloon;
  balloon.material.name = GetParam().material;
  balloon.material.wall_mm = GetParam().wall_mm;
  balloon.material.chart = GetParam().chart;
  balloon.radius_mm = 0.5 * rest_diameter_mm(GetParam().chart);
  InflateOptions options;
  for (const ChartPoint& point : GetParam().chart)
    options.pressures_atm.push_back(point.pressure_atm);
  const auto points = inflate(balloon, options);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(points[i].converged);
    EXPECT_NEAR(points[i].diameter_mm, GetParam().chart[i].diameter_mm,
                2e-3 * GetParam().chart[i].diameter_mm);
  }
}

INSTANTIATE_TEST_SUITE_P(Balloons, ChartedBalloon, ::testing::ValuesIn(testing::charted_balloons()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Inflate, ChartedBalloonsGrowLongerByNoMoreThanMeasuredOnes) {
  // Coronary balloons grow by 0.6 to 2.0 mm up to rated pressure (Amstutz 2023).
  for (const testing::Charted& charted : testing::charted_balloons()) {
    if (std::string(charted.name).find("compliant") == std::string::npos) continue;
    FreeBalloon balloon;
    balloon.length_mm = 20.0;
    balloon.material.name = charted.material;
    balloon.material.wall_mm = charted.wall_mm;
    balloon.material.chart = charted.chart;
    balloon.radius_mm = 0.5 * rest_diameter_mm(charted.chart);
    const auto points = inflate(balloon, at_pressures({charted.chart.back().pressure_atm}));
    EXPECT_GT(points[0].length_mm, 20.0) << charted.name;
    EXPECT_LT(points[0].length_mm, 22.0) << charted.name;
  }
}

TEST(Inflate, WorkOfThePressureIsTheEnergyStored) {
  InflateOptions options;
  const double unloaded = units::kPi * kRadius * kRadius * (kLength + 4.0 / 3.0 * kRadius);
  for (int k = 0; k <= 20; ++k) options.volumes_mm3.push_back(unloaded * (1.0 + 0.05 * k));
  const auto points = inflate(rubber(BalloonEnds::hemispheres), options);
  double work = 0.0;  // [mJ]: 1 Pa mm3 = 1e-6 mJ
  for (std::size_t i = 1; i < points.size(); ++i)
    work += 0.5e-6 * units::pascal_from_atm(points[i].pressure_atm + points[i - 1].pressure_atm) *
            (points[i].volume_mm3 - points[i - 1].volume_mm3);
  EXPECT_NEAR(work, points.back().energy_mj, 0.01 * work);
}

TEST(Inflate, VertexBlockDescentFindsTheStatesOfNewton) {
  FreeBalloon balloon = rubber(BalloonEnds::hemispheres);
  balloon.length_mm = 8.0;
  InflateOptions options = at_loads({1.5, 3.0, 4.5});
  options.around = 16;
  const auto newton = inflate(balloon, options);
  options.solver = InflateSolver::vbd;
  options.backend = Backend::cpu;
  const auto descent = inflate(balloon, options);
  for (std::size_t i = 0; i < newton.size(); ++i) {
    EXPECT_TRUE(descent[i].converged);
    EXPECT_NEAR(descent[i].diameter_mm, newton[i].diameter_mm, 5e-4 * newton[i].diameter_mm);
    EXPECT_NEAR(descent[i].volume_mm3, newton[i].volume_mm3, 1e-3 * newton[i].volume_mm3);
    EXPECT_NEAR(descent[i].energy_mj, newton[i].energy_mj, 5e-3 * newton[i].energy_mj);
  }
}

TEST(Inflate, ThePapersSolverIsNeverAtRestAndSaysSo) {
  FreeBalloon balloon = rubber(BalloonEnds::hemispheres);
  balloon.length_mm = 4.0;
  InflateOptions options = at_loads({3.0});
  options.around = 12;
  options.solver = InflateSolver::paper;
  const auto points = inflate(balloon, options);
  EXPECT_FALSE(points[0].converged);
  EXPECT_GT(points[0].residual, 0.01);
  EXPECT_TRUE(std::isfinite(points[0].diameter_mm));
}

TEST(Inflate, PointsComeInTheOrderAskedFor) {
  const auto points = inflate(rubber(BalloonEnds::tube), at_pressures({0.3, 0.0, 0.6}));
  EXPECT_LT(points[1].diameter_mm, points[0].diameter_mm);
  EXPECT_LT(points[0].diameter_mm, points[2].diameter_mm);
  EXPECT_NEAR(points[1].diameter_mm, 2.0 * kRadius, 1e-9);
  EXPECT_NEAR(points[1].length_mm, kLength, 1e-9);
  EXPECT_TRUE(points[1].converged);
}

TEST(Inflate, RefusesNonsense) {
  const FreeBalloon good = rubber(BalloonEnds::tube);
  InflateOptions both = at_pressures({1.0});
  both.volumes_mm3 = {100.0};
  EXPECT_THROW(inflate(good, {}), OptionError);
  EXPECT_THROW(inflate(good, both), OptionError);
  EXPECT_THROW(inflate(good, at_pressures({-1.0})), OptionError);
  EXPECT_THROW(inflate(good, at_pressures({std::nan("")})), OptionError);
  EXPECT_THROW(inflate(good, at_volumes({1.0})), InputError);
  InflateOptions piece = at_loads({1.0});
  piece.solver = InflateSolver::vbd;  // knows no moving end planes
  EXPECT_THROW(inflate(good, piece), OptionError);
  FreeBalloon bad = good;
  bad.material.wall_mm = 0.0;
  EXPECT_THROW(inflate(bad, at_pressures({1.0})), OptionError);
  bad = good;
  bad.material.name = "paper";
  EXPECT_THROW(inflate(bad, at_pressures({1.0})), OptionError);
  bad = good;
  bad.radius_mm = std::nan("");
  EXPECT_THROW(inflate(bad, at_pressures({1.0})), OptionError);
  bad = good;
  bad.material.chart = {{4, 2.85}, {6, 2.93}};  // another radius
  EXPECT_THROW(inflate(bad, at_pressures({1.0})), OptionError);
}

CatalogueBalloon entry() {
  CatalogueBalloon balloon;
  balloon.name = "sc-3.0";
  balloon.chart = testing::charted_balloons()[0].chart;
  return balloon;
}

TEST(BalloonCatalogue, AnEntryBecomesAFreeBalloon) {
  const FreeBalloon balloon = free_balloon(entry());
  EXPECT_NEAR(balloon.radius_mm, 0.5 * 2.69, 1e-12);
  EXPECT_EQ(balloon.length_mm, 15.0);
  EXPECT_EQ(balloon.material.chart.size(), 6u);
  CatalogueBalloon plain = entry();
  plain.chart.clear();
  EXPECT_EQ(free_balloon(plain).radius_mm, 1.5);
}

TEST(BalloonCatalogue, NamesTheBalloonAndTheFieldThatIsWrong) {
  const auto message = [](const CatalogueBalloon& balloon) -> std::string {
    try {
      balloon.validate();
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_EQ(message(entry()), "");
  CatalogueBalloon bad = entry();
  bad.wall_mm = 0.0;
  EXPECT_NE(message(bad).find("\"sc-3.0\": wall_mm is 0"), std::string::npos);
  bad = entry();
  bad.folds = 4;
  EXPECT_NE(message(bad).find("folds is 4"), std::string::npos);
  bad = entry();
  bad.material = "steel";
  EXPECT_NE(message(bad).find("material"), std::string::npos);
  bad = entry();
  bad.representative = false;
  EXPECT_NE(message(bad).find("source"), std::string::npos);
  bad = entry();
  bad.rated_burst_pressure_atm = 6.0;
  EXPECT_NE(message(bad).find("rated_burst_pressure_atm"), std::string::npos);
  bad = entry();
  bad.nominal_diameter_mm = 3.5;
  EXPECT_NE(message(bad).find("its chart gives 3.000 mm"), std::string::npos);
  bad = entry();
  bad.name = "../x";
  EXPECT_NE(message(bad).find("Rename it"), std::string::npos);
}

TEST(BalloonCatalogue, AMissingNameIsAnsweredWithTheNamesThereAre) {
  const std::vector<CatalogueBalloon> catalogue{entry()};
  EXPECT_EQ(find_balloon(catalogue, "sc-3.0").name, "sc-3.0");
  try {
    find_balloon(catalogue, "sc-9");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("it has sc-3.0"), std::string::npos);
  }
  try {
    find_balloon(catalogue, "sc3.0");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::bad_config);
    EXPECT_NE(std::string(error.what()).find("did you mean sc-3.0?"), std::string::npos);
  }
}

}  // namespace
}  // namespace angio::simulation
