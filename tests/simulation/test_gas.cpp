#include <gtest/gtest.h>

#include <cmath>

#include "simulation/materials/gas.hpp"
#include "simulation/run/schedule.hpp"

namespace angio::simulation::detail {
namespace {

TEST(GasLaw, MeetsTheBalloonWhereBothAgree) {
  for (const double lower : {0.0, 3e6, 8e6})
    for (const double compliance : {0.0, 1e-7, 1e-4, 10.0}) {
      const GasLaw<double> law{lower, 2e6, 5e4, 7e6, 9e5, 0, 0};
      const double p0 = 1.1e5, volume = 9.0;
      const double p = meet(law, p0, volume, compliance);
      const double v = volume + compliance * (p - p0);
      EXPECT_GT(v, 0.0);
      EXPECT_NEAR(p, pressure_at(law, v), 1e-6 * p);
    }
}

TEST(GasLaw, NeverPassesTheTopPressure) {
  const GasLaw<double> law{1e9, 1e9, 1e6, 1e12, 8e5, 0, 0};
  for (const double volume : {0.1, 1.0, 100.0}) {
    EXPECT_LE(pressure_at(law, volume), 8e5);
    EXPECT_LE(meet(law, 1e5, volume, 1e-5), 8e5);
  }
}

TEST(Inflator, PhasesFollowOneAnother) {
  SimulationOptions options;
  options.frame_s = 0.1;
  options.inflation.inflate_s = 1.0;
  options.inflation.hold_s = 0.5;
  options.inflation.deflate_s = 0.4;
  options.inflation.rest_s = 0.2;
  const Inflator inflator(options, 5.0, 50.0);
  EXPECT_EQ(inflator.frame_count(), 1 + 1 + 10 + 5 + 4 + 2);
  for (int f = 1; f < inflator.frame_count(); ++f)
    EXPECT_GE(int(inflator.phase(f)), int(inflator.phase(f - 1)));
  EXPECT_EQ(inflator.phase(inflator.frame_count() - 1), Phase::rest);
}

TEST(Inflator, AddsGasEvenlyWhileTheBalloonIsBelowItsNominalVolume) {
  SimulationOptions options;
  const double start = 5.0, nominal = 50.0;
  Inflator inflator(options, start, nominal);
  double gas = outside_pressure(options) * start, first = 0.0;
  for (int f = 2; inflator.phase(f) == Phase::inflate; ++f) {
    const double volume = 40.0;
    const GasLaw<double> law = inflator.law(f, gas, volume);
    const double added = pressure_at(law, volume) * volume - gas;
    if (f == 2) first = added;
    if (pressure_at(law, volume) < law.top * (1 - 1e-12)) {
      EXPECT_NEAR(added, first, 1e-6 * first);
    }
    gas += added;
  }
}

TEST(Inflator, EndsAtThePeakPressureWhateverTheVolume) {
  SimulationOptions options;
  const double peak = outside_pressure(options) + 101325.0 * options.inflation.peak_pressure_atm;
  for (const double growth : {0.5, 1.0, 1.3}) {  // volume at the peak pressure over the nominal
    Inflator inflator(options, 5.0, 50.0);
    double gas = outside_pressure(options) * 5.0, volume = 5.0, p = 0.0;
    for (int f = 2; inflator.phase(f) == Phase::inflate; ++f) {
      const GasLaw<double> law = inflator.law(f, gas, volume);
      // A balloon of V = 50 growth (p / peak)^(1/4): meet it by bisection in V.
      double low = 1.0, high = 100.0;
      for (int i = 0; i < 60; ++i) {
        volume = 0.5 * (low + high);
        const bool too_small =
            volume < 50.0 * growth * std::pow(pressure_at(law, volume) / peak, 0.25);
        (too_small ? low : high) = volume;
      }
      p = pressure_at(law, volume);
      gas = p * volume;
      EXPECT_LE(p, peak);
    }
    EXPECT_NEAR(p, peak, 1e-6 * peak);
  }
}

}  // namespace
}  // namespace angio::simulation::detail
