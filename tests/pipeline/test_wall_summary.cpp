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

/// What metrics.json says where the balloon presses [kPa] and the named region has flowed.
double over_strength(double pressure, simulation::WallRegion region, double plastic_strain) {
  const simulation::LayeredWall wall = tube();
  simulation::SimulationFrame frame;
  frame.contact_pressure_kpa.assign(wall.vertices.size() / 4, pressure);
  frame.wall_stress = [&] {
    std::vector<simulation::WallStress> stresses(wall.wedges.size());
    for (std::size_t w = 0; w < wall.wedges.size(); ++w)
      if (wall.region[w] == region) stresses[w].plastic_strain = plastic_strain;
    return stresses;
  };
  return wall_summary(wall, frame, frame).at("over_strength_percent").get<double>();
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

}  // namespace
}  // namespace angio::pipeline
