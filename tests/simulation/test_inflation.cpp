#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/error.hpp"
#include "core/units.hpp"
#include "tests/simulation/models.hpp"

/// A balloon alone, against closed forms.
namespace angio::simulation {
namespace {

constexpr double kC1 = 1.031e6, kC2 = 3.69e6;  // polyurethane [Pa]
constexpr double kWall = 0.02;

SimulationModel alone(TriangleMesh balloon) {
  SimulationModel model;
  model.balloon = std::move(balloon);
  model.balloon_rest = model.balloon.vertices;
  model.balloon_fixed.assign(model.balloon.vertices.size(), 0);
  model.measure_point = {0, 0, 1e-3};
  model.measure_tangent = {0, 0, 1};
  return model;
}

SimulationOptions rubber(double peak_atm) {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.balloon.wall_mm = kWall;
  options.inflation.peak_pressure_atm = peak_atm;
  options.inflation.inflate_s = 1.0;
  options.inflation.hold_s = 0.1;
  options.inflation.deflate_s = 0.5;
  options.inflation.rest_s = 0.0;
  return options;
}

SimulationFrame peak_of(const SimulationModel& model, const SimulationOptions& options) {
  SimulationFrame last;
  simulate(model, options, [&](const SimulationFrame& f) {
    if (f.phase == Phase::hold) last = f;
  });
  return last;
}

TriangleMesh sphere(double radius, int rings, int around) {
  TriangleMesh mesh = testing::closed_tube(2.0, rings, around, [](double) { return 1.0; });
  for (Vec3& v : mesh.vertices) {
    const double polar = 0.5 * units::kPi * v.z, angle = std::atan2(v.y, v.x);
    const bool pole = v.x == 0.0 && v.y == 0.0;
    v = pole ? Vec3{0, 0, v.z > 0 ? radius : -radius}
             : Vec3{radius * std::cos(polar) * std::cos(angle),
                    radius * std::cos(polar) * std::sin(angle), radius * std::sin(polar)};
  }
  return mesh;
}

TEST(FreeInflation, ASphereFollowsItsPressureRadiusCurve) {
  const double radius = 1.5;
  const SimulationModel model = alone(sphere(radius, 19, 24));
  for (const double l : {1.1, 1.2}) {
    const double p =
        4.0 * kWall / radius * (kC1 * (1.0 / l - std::pow(l, -7)) + kC2 * (l - std::pow(l, -5)));
    const SimulationFrame frame = peak_of(model, rubber(units::atm_from_pascal(p)));
    EXPECT_NEAR(frame.pressure_atm, units::atm_from_pascal(p), 1e-3 * frame.pressure_atm);
    const double grown = std::cbrt(frame.balloon_volume_mm3 / enclosed_volume(model.balloon));
    EXPECT_NEAR(grown - 1.0, l - 1.0, 0.01 * (l - 1.0));
  }
}

TEST(FreeInflation, AClosedTubeFollowsItsPressureRadiusCurve) {
  // Rows of l1, l2 and p R / H [MPa] solve dw/dl1 = p R l1 l2 / H, dw/dl2 = p R l1^2 / (2 H).
  const double radius = 1.5, length = 16.0;
  const SimulationModel model =
      alone(testing::closed_tube(length, 41, 32, [&](double) { return radius; }));
  for (const auto& [l1, l2, load] : {std::array{1.1, 0.9967, 2.945}, {1.2, 0.9885, 4.751}}) {
    const double p = units::pascal_from_megapascal(load) * kWall / radius;
    const SimulationFrame frame = peak_of(model, rubber(units::atm_from_pascal(p)));
    EXPECT_NEAR(frame.balloon_diameter_mm / (2.0 * radius) - 1.0, l1 - 1.0, 0.02 * (l1 - 1.0));
    const std::size_t middle = 20 * 32;
    EXPECT_NEAR(frame.stretch_1[middle], l1, 0.004);
    EXPECT_NEAR(frame.stretch_2[middle], l2, 0.004);
    EXPECT_NEAR(frame.thickness_mm[middle], kWall / (l1 * l2), 1e-4);
  }
}

TEST(FreeInflation, GasObeysItsLawInEveryPhase) {
  const SimulationModel model =
      alone(testing::closed_tube(8.0, 13, 12, [](double) { return 1.0; }));
  const SimulationOptions options = rubber(0.5);
  const double outside = 101325.0 + 1e3 * options.inflation.outside_pressure_kpa;
  std::map<int, double> gas;
  double held = 0.0, start = 0.0, volume_start = 0.0, volume_end = 0.0;
  simulate(model, options, [&](const SimulationFrame& f) {
    gas[f.frame] = (outside + units::pascal_from_atm(f.pressure_atm)) * f.balloon_volume_mm3;
    if (f.frame == 0) start = gas[0], volume_start = f.balloon_volume_mm3;
    if (f.phase == Phase::hold) {
      if (held == 0.0) held = gas[f.frame - 1];
      EXPECT_NEAR(gas[f.frame], held, 1e-6 * held);  // nothing leaks
    }
    EXPECT_LE(f.pressure_atm, options.inflation.peak_pressure_atm * (1 + 1e-9));
    volume_end = f.balloon_volume_mm3;
  });
  EXPECT_NEAR(gas.rbegin()->second, start, 1e-6 * start);
  EXPECT_NEAR(volume_end, volume_start, 1e-3 * volume_start);
}

TEST(FreeInflation, GoesPastALimitPointWithoutBursting) {
  // This tube carries 8.25 H / R = 1.09 atm at most; it is asked for 3.
  const SimulationModel model =
      alone(testing::closed_tube(8.0, 13, 16, [](double) { return 1.5; }));
  std::vector<double> volumes;
  const SimulationSummary summary = simulate(model, rubber(3.0), [&](const SimulationFrame& f) {
    for (const Vec3& v : f.balloon) ASSERT_TRUE(std::isfinite(norm_squared(v)));
    volumes.push_back(f.balloon_volume_mm3);
  });
  EXPECT_LT(summary.peak_pressure_atm, 1.5);
  ASSERT_FALSE(summary.warnings.empty());
  for (std::size_t i = 1; i < volumes.size(); ++i) {
    EXPECT_LT(volumes[i], 1.5 * volumes[i - 1]);  // no jump
    EXPECT_GT(volumes[i], volumes[i - 1] / 1.5);
  }
}

// dD/D = dp R (1 - nu/2) / (E t) of a closed cylinder with nu = 1/2: 5.1 % for 20 um at R = 1.5 mm.
TEST(FreeInflation, AWrappedPa12BalloonIsSemiCompliant) {
  testing::StenosedTube p;
  p.balloon_rings = 20;
  p.balloon_around = 16;
  SimulationModel model = testing::make_model(p);
  model.wall = {};
  model.wall_fixed.clear();
  model.wall_abscissa.clear();
  model.wall_group.clear();
  std::map<double, double> diameter;
  for (const double atm : {6.0, 14.0}) {
    SimulationOptions options;
    options.inflation.peak_pressure_atm = atm;
    options.inflation.inflate_s = 1.0;
    options.inflation.hold_s = 0.1;
    options.inflation.deflate_s = 0.025;
    options.inflation.rest_s = 0.0;
    diameter[atm] = peak_of(model, options).balloon_diameter_mm;
  }
  const double growth = (diameter[14.0] - diameter[6.0]) / 3.0;
  const double linear = 8.0 * 101325.0 * 1.5 * 0.75 / (900e6 * 0.02);
  EXPECT_NEAR(growth, linear, 0.15 * linear);
  // At 6 atm: the nominal diameter and the same line from zero.
  EXPECT_NEAR(diameter[6.0], 3.0 * (1.0 + 0.75 * linear), 0.02 * 3.0);
}

TEST(SimulationOptions, DefaultsAreValid) { EXPECT_NO_THROW(SimulationOptions{}.validate()); }

TEST(SimulationOptions, NamesTheFieldThatIsOutOfRange) {
  SimulationOptions options;
  options.inflation.peak_pressure_atm = 60.0;
  try {
    options.validate();
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_NE(std::string(error.what()).find("inflation.peak_pressure_atm"), std::string::npos);
  }
}

TEST(Simulate, SaysWhenCudaIsNotThere) {
  SimulationOptions options;
  options.backend = Backend::cuda;
  try {
    simulate(alone(sphere(1.0, 7, 8)), options, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::unavailable);
  }
}

TEST(Simulate, RefusesABalloonThatIsOpen) {
  SimulationModel model = alone(sphere(1.0, 7, 8));
  model.balloon.triangles.pop_back();
  EXPECT_THROW(simulate(model, {}, {}), InputError);
}

}  // namespace
}  // namespace angio::simulation
