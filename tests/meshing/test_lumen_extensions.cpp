#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "meshing/meshing.hpp"
#include "testing/meshing/analytic_vessels.hpp"
#include "tests/meshing/cap_centre.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

double edge_sum(const LumenMesh& lumen, const std::vector<int>& loop) {
  double sum = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += distance(lumen.open.vertices[std::size_t(loop[i])],
                    lumen.open.vertices[std::size_t(loop[(i + 1) % loop.size()])]);
  return sum;
}

TEST(LumenExtensions, AreStraightTubesOfTheAskedLength) {
  const auto vessel = test::make_fork(1.5, 1.1, 12.0, 12.0, 0.6, 0.3);
  LumenMeshOptions options;
  const LumenMesh plain = mesh_lumen(vessel.level_set, vessel.tree, options);
  options.extension_diameters = 3.0;
  const LumenMesh extended = mesh_lumen(vessel.level_set, vessel.tree, options);
  EXPECT_TRUE(extended.watertight);
  EXPECT_EQ(extended.self_intersection_count, 0);
  EXPECT_GT(extended.min_angle_degrees, 20.0);
  EXPECT_EQ(boundary_loops(extended.open).size(), 3U);
  EXPECT_THAT(extended.warnings, testing::IsEmpty());
  const double radii[3] = {1.5, 1.1, 1.1};
  double added = 0.0;
  for (int id = 1; id <= 3; ++id) {
    const double radius = radii[id - 1];
    EXPECT_NEAR(distance(cap_centre(plain, id), cap_centre(extended, id)), 6.0 * radius,
                0.02 * 6.0 * radius);
    added += pi * radius * radius * 6.0 * radius;
  }
  EXPECT_NEAR(enclosed_volume(extended.capped) - enclosed_volume(plain.capped), added,
              0.03 * added);
  // The new rims are round: the perimeter is that of the regular polygon with the circle's area.
  for (const auto& loop : boundary_loops(extended.open)) {
    const auto n = double(loop.size());
    const double radius = radii[extended.inlet_outlet_id[std::size_t(loop[0])] - 1];
    const double perimeter = 2.0 * radius * std::sqrt(pi * n * std::tan(pi / n));
    EXPECT_NEAR(edge_sum(extended, loop) / perimeter, 1.0, 0.02);
  }
  // The lumen's own vertices stay what they were.
  for (std::size_t v = 0; v < plain.open.vertices.size(); ++v)
    EXPECT_EQ(plain.open.vertices[v], extended.open.vertices[v]);
}

TEST(LumenExtensions, AreAnEdgeLongAtLeastAndSaySo) {
  const auto vessel = test::make_tube(10.0, 0.3, [](double) { return 1.5; });
  LumenMeshOptions options;
  const LumenMesh plain = mesh_lumen(vessel.level_set, vessel.tree, options);
  options.extension_diameters = 0.001;
  const LumenMesh extended = mesh_lumen(vessel.level_set, vessel.tree, options);
  EXPECT_GT(extended.min_angle_degrees, 15.0);
  EXPECT_GT(distance(cap_centre(extended, 1), cap_centre(extended, 2)),
            distance(cap_centre(plain, 1), cap_centre(plain, 2)) + 2.0 * plain.quality.edge_min_mm);
  EXPECT_THAT(extended.warnings, testing::Contains(testing::HasSubstr("lengthened")));
}

TEST(LumenExtensions, ThatWouldCrossTheLumenAreLeftOutWithAWarning) {
  // A hook: its end points back at its own beginning.
  const auto vessel = test::make_arc(1.0, 4.0, 1.5 * pi, 0.3);
  LumenMeshOptions options;
  options.extension_diameters = 6.0;
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, options);
  EXPECT_TRUE(lumen.watertight);
  EXPECT_EQ(lumen.self_intersection_count, 0);
  EXPECT_THAT(lumen.warnings, testing::Contains(testing::HasSubstr("no extension")));
}

}  // namespace
}  // namespace angio::meshing
