#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/error.hpp"
#include "simulation/pbd/gas.hpp"
#include "testing/simulation/models.hpp"

/// The paper's gas of each tet, and what it makes of a balloon that the gas law fills as it should.
namespace angio::simulation {
namespace {

/// The tets of a closed tube around one point in its middle, without a membrane.
struct Fan {
  TriangleMesh mesh = testing::closed_tube(3.0, 8, 10, [](double) { return 1.0; });
  std::vector<Vec3> apex = std::vector<Vec3>(mesh.triangles.size());
  std::vector<double> inverse_mass = std::vector<double>(mesh.vertices.size(), 1.0), target;
  std::vector<int> corners;

  explicit Fan(double grown) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      corners.insert(corners.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
      target.push_back(grown * volume(t));
    }
  }
  [[nodiscard]] double volume(std::size_t t) const {
    const Triangle& v = mesh.triangles[t];
    return tet_volume(apex[t], mesh.vertices[std::size_t(v[0])], mesh.vertices[std::size_t(v[1])],
                      mesh.vertices[std::size_t(v[2])]);
  }
  void project(int times) {
    detail::PbdGas<double> gas;
    gas.apex = apex.data();
    gas.triangles = corners.data();
    gas.inverse_mass = inverse_mass.data();
    for (int i = 0; i < times; ++i)
      for (std::size_t t = 0; t < target.size(); ++t)
        detail::project_gas_tet(gas, int(t), target[t], mesh.vertices.data());
  }
};

TEST(PbdGas, AProjectionIsNewtonsStepOnThePressure) {
  // C = Q / V - p, linear in V: V - C / (dC/dV), Q = p V_t.
  for (const double v : {0.6, 0.9, 1.0, 1.4}) {
    const double c = 1.0 / v - 1.0, slope = -1.0 / (v * v);
    EXPECT_NEAR(detail::pbd_gas_volume(v, 1.0), v - c / slope, 1e-12);
  }
  EXPECT_GT(detail::pbd_gas_volume(3.0, 1.0), 0.0);  // where the paper's step diverges
  EXPECT_GT(detail::pbd_gas_volume(-1.0, 1.0), 0.0);
}

TEST(PbdGas, WithoutASkinEachTetGetsItsVolume) {
  for (const double grown : {1.5, 0.7}) {
    Fan fan(grown);
    fan.project(400);
    double worst = 0.0;
    for (std::size_t t = 0; t < fan.target.size(); ++t)
      worst = std::max(worst, std::abs(fan.volume(t) / fan.target[t] - 1.0));
    EXPECT_LT(worst, 1e-4);
  }
}

struct Filled {
  double volume = 0.0, diameter = 0.0, residual = 0.0, pressure = 0.0;
};

/// At the peak, with the volume ramped to 1.5 times the start's.
Filled fill(GasModel gas, int sweeps) {
  testing::StenosedTube tube;
  SimulationModel model = testing::make_model(tube);
  model.balloon = testing::closed_tube(
      12.0, 26, 20, [](double z) { return 0.1 + 0.9 * std::sqrt(1.0 - std::pow(z / 6.0, 4)); });
  model.balloon_rest = model.balloon.vertices;
  model.wall = {};
  model.wall_fixed.clear();
  model.wall_abscissa.clear();
  model.wall_group.clear();
  model.guidewire.clear();
  for (int i = 0; i < 24; ++i) model.guidewire.push_back({0.0, 0.0, 12.0 * (i / 23.0 - 0.5)});
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.inflation.control = InflationControl::volume;
  options.inflation.peak_volume_mm3 = 1.5 * enclosed_volume(model.balloon);
  options.inflation.inflate_s = 0.5;
  options.inflation.hold_s = 0.25;
  options.inflation.deflate_s = options.inflation.rest_s = 0.1;
  options.gas_model = gas;
  options.sweeps = sweeps;
  options.backend = Backend::cpu;
  Filled peak;
  simulate(model, options, [&](const SimulationFrame& f) {
    if (f.phase == Phase::hold)
      peak = {f.balloon_volume_mm3 / options.inflation.peak_volume_mm3, f.balloon_diameter_mm,
              f.residual, f.pressure_atm};
  });
  std::printf("per tet: %d, sweeps: %2d, volume over target: %.4f, residual: %.4f\n",
              gas == GasModel::per_tet ? 1 : 0, sweeps, peak.volume, peak.residual);
  return peak;
}

// The tets fill a part of the balloon, and where their volumes are met
// nothing holds the membrane.
TEST(PbdGas, LeavesTheVolumeToTheNumberOfSweepsWhereTheGasLawMeetsIt) {
  const Filled law = fill(GasModel::enclosed, 5);
  EXPECT_NEAR(law.volume, 1.0, 1e-3);
  EXPECT_LT(law.residual, 0.02);
  const Filled few = fill(GasModel::per_tet, 5), many = fill(GasModel::per_tet, 20);
  for (const Filled& paper : {few, many}) {
    EXPECT_GT(paper.volume, 1.0 / 1.5);  // of the start
    EXPECT_LT(paper.volume, 0.9);
    EXPECT_GT(paper.residual, 1.0);
  }
  EXPECT_GT(std::abs(few.volume - many.volume), 0.01);
}

TEST(PbdGas, TakesCommandsForVolumesOnly) {
  SimulationOptions options;
  options.gas_model = GasModel::per_tet;
  EXPECT_THROW(options.validate(), OptionError);
  options.inflation.control = InflationControl::volume;
  EXPECT_NO_THROW(options.validate());
  options.guidewire.model = GuidewireModel::rod;
  EXPECT_THROW(options.validate(), OptionError);
}

}  // namespace
}  // namespace angio::simulation
