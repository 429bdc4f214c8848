#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/stages/layered_wall.hpp"
#include "simulation/wall.hpp"

namespace angio::pipeline {
namespace {

constexpr double kInner = 1.5, kOuter = 2.1;  // mm

/// A tube of plaque, media and adventitia of the same thickness.
simulation::LayeredWall tube() {
  simulation::TubeWall tube;
  tube.around = 48;
  tube.inner_radius_mm = [](double, double) { return kInner; };
  tube.outer_radius_mm = [](double, double) { return kOuter; };
  tube.layer_shares.assign(3, 1.0);
  tube.layer_regions = {simulation::WallRegion::plaque, simulation::WallRegion::media,
                        simulation::WallRegion::adventitia};
  return simulation::make_tube_wall(tube);
}

std::vector<Vec3> lumen_of(const simulation::LayeredWall& wall) {
  return {wall.vertices.begin(), wall.vertices.begin() + std::ptrdiff_t(wall.vertices.size() / 4)};
}

/// What metrics.json says where the balloon presses [kPa] and the named region has flowed.
double over_strength(double pressure, simulation::WallRegion region, double plastic_strain) {
  const simulation::LayeredWall wall = tube();
  simulation::SimulationFrame frame;
  frame.contact_pressure_kpa.assign(wall.vertices.size() / 4, pressure);
  frame.wall = lumen_of(wall);
  frame.wall_stress = [&] {
    std::vector<simulation::WallStress> stresses(wall.wedges.size());
    for (std::size_t w = 0; w < wall.wedges.size(); ++w)
      if (wall.region[w] == region) stresses[w].plastic_strain = plastic_strain;
    return stresses;
  };
  const nlohmann::json told = wall_summary(wall, frame, frame);
  EXPECT_EQ(told.at("over_strength_mm3").get<double>() > 0.0,
            told.at("over_strength_percent").get<double>() > 0.0);
  return told.at("over_strength_percent").get<double>();
}

TEST(WallSummary, OverItsStrengthIsTheShareOfTheVesselsLayersThatHasFlowed) {
  const double third = (kOuter - kInner) / 3.0;
  const auto area = [&](int layer) {
    return std::pow(kInner + (layer + 1) * third, 2) - std::pow(kInner + layer * third, 2);
  };
  EXPECT_NEAR(over_strength(50.0, simulation::WallRegion::media, 0.01),
              100.0 * area(1) / (area(1) + area(2)), 0.1);
  EXPECT_EQ(over_strength(50.0, simulation::WallRegion::plaque, 0.01), 0.0);
  EXPECT_EQ(over_strength(50.0, simulation::WallRegion::media, 0.001), 0.0) << "under 0.2 %";
  EXPECT_EQ(over_strength(0.0, simulation::WallRegion::media, 0.01), 0.0) << "not touched";
}

TEST(WallSummary, QuantilesAreByVolumeOfWhatTheBalloonTouches) {
  const simulation::LayeredWall wall = tube();
  simulation::SimulationFrame frame;
  const std::size_t count = wall.vertices.size() / 4;
  frame.wall = lumen_of(wall);
  frame.contact_pressure_kpa.assign(count, 0.0);
  const double middle = 0.5 * simulation::TubeWall().length_mm;
  for (std::size_t v = 0; v < count; ++v)  // the half that lies at lower z
    if (wall.vertices[v].z < middle - 1e-6) frame.contact_pressure_kpa[v] = 10.0;
  frame.wall_stress = [&] {
    std::vector<simulation::WallStress> stresses(wall.wedges.size());
    for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
      double z = 0.0;
      for (const int v : wall.wedges[w]) z += wall.vertices[std::size_t(v)].z / 6.0;
      stresses[w].principal_kpa = z > middle ? 1000.0 : 100.0 + 10.0 * z;
      stresses[w].log_strain = 0.1 * int(wall.region[w]);
    }
    return stresses;
  };
  const nlohmann::json media = wall_summary(wall, frame, frame).at("regions").at("media");
  EXPECT_LT(media.at("touched_principal_stress_p99_kpa").get<double>(), 100.0 + 10.0 * middle);
  EXPECT_GT(media.at("touched_principal_stress_p99_kpa").get<double>(),
            media.at("touched_principal_stress_median_kpa").get<double>());
  EXPECT_NEAR(media.at("touched_log_strain_p95").get<double>(), 0.1, 1e-12);
  // Nothing says how hard the balloon is blown up, so any pressure presses.
  EXPECT_NEAR(media.at("pressed_log_strain_p95").get<double>(), 0.1, 1e-12);
  frame.pressure_atm = 8.0;
  EXPECT_TRUE(wall_summary(wall, frame, frame)
                  .at("regions")
                  .at("media")
                  .at("pressed_log_strain_p95")
                  .is_null())
      << "10 kPa is less than a twentieth of 811";
  frame.contact_pressure_kpa.assign(count, 0.0);
  EXPECT_TRUE(wall_summary(wall, frame, frame)
                  .at("regions")
                  .at("media")
                  .at("touched_log_strain_p99")
                  .is_null());
}

TEST(PlaqueEccentricity, IsTheThicknessOfIntimaPlaqueAndMediaRoundThePlace) {
  // Circles of 1 and 2 mm whose middles are apart: media reach to the outer third of the wall.
  for (const double apart : {0.0, 0.3, 0.6}) {
    simulation::TubeWall tube;
    tube.around = 48;
    tube.inner_radius_mm = [](double, double) { return 1.0; };
    tube.outer_radius_mm = [=](double angle, double) {
      return apart * std::cos(angle) + std::sqrt(4.0 - std::pow(apart * std::sin(angle), 2));
    };
    tube.layer_shares.assign(3, 1.0);
    tube.layer_regions = {simulation::WallRegion::plaque, simulation::WallRegion::media,
                          simulation::WallRegion::adventitia};
    simulation::SimulationModel model;
    model.layered_wall = simulation::make_tube_wall(tube);
    const std::size_t count = model.layered_wall.vertices.size() / 4;
    for (std::size_t v = 0; v < count; ++v) {
      const Vec3& p = model.layered_wall.vertices[v];
      model.wall.vertices.push_back(p);
      model.wall_abscissa.push_back(10.0 + p.z);
      model.wall_group.push_back(0);
    }
    EXPECT_NEAR(plaque_eccentricity(model, 11.0, 0.6), 2.0 * apart / (1.0 + apart), 1e-6);
    EXPECT_TRUE(std::isnan(plaque_eccentricity(model, 30.0, 0.6)));
  }
}

}  // namespace
}  // namespace angio::pipeline
