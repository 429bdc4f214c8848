#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "core/centerline_trees.hpp"
#include "core/error.hpp"
#include "core/surface_rims.hpp"
#include "meshing/detail/remesh.hpp"
#include "meshing/meshing.hpp"
#include "testing/meshing/analytic_vessels.hpp"
#include "tests/meshing/cap_centre.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

struct MeshedCase {
  const char* name;
  test::Vessel vessel;
  double spacing;
};
void PrintTo(const MeshedCase& c, std::ostream* stream) { *stream << c.name; }

std::vector<MeshedCase> meshed_cases() {
  return {{"Tube", test::make_tube(20.0, 0.3, [](double) { return 1.5; }), 0.3},
          {"StenosedTube", test::make_tube(24.0, 0.3, test::stenosis(1.5, 12.0, 5.0, 0.6)), 0.3},
          {"CoarseTube", test::make_tube(20.0, 0.5, [](double) { return 1.0; }), 0.5},
          {"Arc", test::make_arc(1.5, 8.0, 2.5, 0.3), 0.3},
          // Inlet and outlet lie in one plane: a cut at one end must not touch the other.
          {"HalfTurn", test::make_arc(1.5, 6.0, pi, 0.3), 0.3},
          {"Fork", test::make_fork(1.5, 1.1, 12.0, 12.0, 0.6, 0.3), 0.3},
          {"TwoTubes", test::make_two_tubes(20.0, 1.5, 0.3), 0.3},
          {"Trifurcation", test::make_branching(3, 1.5, 1.0, 8.0, 9.0, 0.9, 0.3), 0.3}};
}

class MeshLumen : public testing::TestWithParam<MeshedCase> {
 protected:
  const test::Vessel& vessel() const { return GetParam().vessel; }
  /// Made once for all tests of a vessel.
  const LumenMesh& mesh() const {
    static std::map<std::string, LumenMesh> made;
    const auto [at, is_new] = made.try_emplace(GetParam().name);
    if (is_new) at->second = mesh_lumen(vessel().level_set, vessel().tree, {});
    return at->second;
  }
};

TEST_P(MeshLumen, IsClosedManifoldAndOnePieceWhenCapped) {
  const LumenMesh& lumen = mesh();
  const SurfaceTopology topology = surface_topology(lumen.capped);
  EXPECT_TRUE(topology.is_closed());
  const auto trees = int(separate_trees(vessel().tree).size());
  EXPECT_EQ(topology.component_count, trees);
  EXPECT_EQ(topology.euler_number, 2 * trees);
  EXPECT_TRUE(lumen.watertight);
  EXPECT_GT(enclosed_volume(lumen.capped), 0.0);
  EXPECT_THAT(lumen.warnings, testing::IsEmpty());
}

TEST_P(MeshLumen, HasNoSelfIntersections) {
  const LumenMesh& lumen = mesh();
  EXPECT_EQ(lumen.self_intersection_count, 0);
  EXPECT_EQ(count_self_intersections(lumen.capped), 0);
}

TEST_P(MeshLumen, IsOpenAtEveryLineEndWithPlanarRims) {
  const LumenMesh& lumen = mesh();
  const auto loops = boundary_loops(lumen.open);
  const std::size_t trees = separate_trees(vessel().tree).size();
  ASSERT_EQ(loops.size(), vessel().tree.paths.size() + trees);
  for (const auto& loop : loops) {
    const auto at = [&](std::size_t i) {
      return lumen.open.vertices[std::size_t(loop[i % loop.size()])];
    };
    Vec3 area;
    for (std::size_t i = 0; i < loop.size(); ++i) area += cross(at(i) - at(0), at(i + 1) - at(0));
    for (std::size_t i = 0; i < loop.size(); ++i)
      EXPECT_NEAR(dot(at(i) - at(0), normalized(area)), 0.0, 1e-9);
  }
}

TEST_P(MeshLumen, TellsInletAndOutletsApart) {
  const LumenMesh& lumen = mesh();
  ASSERT_EQ(lumen.inlet_outlet_id.size(), lumen.capped.vertices.size());
  std::map<int, Vec3> sum;
  std::map<int, double> count;
  for (std::size_t v = 0; v < lumen.capped.vertices.size(); ++v) {
    sum[lumen.inlet_outlet_id[v]] += lumen.capped.vertices[v];
    ++count[lumen.inlet_outlet_id[v]];
  }
  const auto& paths = vessel().tree.paths;
  const std::vector<CenterlineTree> trees = separate_trees(vessel().tree);
  ASSERT_EQ(count.size(), paths.size() + trees.size() + 1);  // wall, inlets, outlets
  const double reach = 2.0 * paths[0].inscribed_radius.front();
  EXPECT_LT(distance(sum[1] / count[1], paths[0].points.front()), reach);
  for (std::size_t p = 0; p < paths.size(); ++p) {
    const int id = int(p) + 2;
    EXPECT_LT(distance(sum[id] / count[id], paths[p].points.back()), reach);
  }
  for (std::size_t t = 1; t < trees.size(); ++t) {  // further inlets behind all outlets
    const int id = int(paths.size() + t) + 1;
    EXPECT_LT(distance(sum[id] / count[id], trees[t].paths.front().points.front()), reach);
  }
  // A triangle is of a cap exactly if all its corners carry the cap's id.
  std::size_t cap_triangles = 0;
  for (const Triangle& t : lumen.capped.triangles) {
    const int a = lumen.inlet_outlet_id[std::size_t(t[0])];
    cap_triangles += a > 0 && a == lumen.inlet_outlet_id[std::size_t(t[1])] &&
                     a == lumen.inlet_outlet_id[std::size_t(t[2])];
  }
  EXPECT_EQ(cap_triangles, lumen.capped.triangles.size() - lumen.open.triangles.size());
}

TEST_P(MeshLumen, HasNoTriangleBelowTwentyDegrees) {
  const LumenMesh& lumen = mesh();
  double least = 180.0;
  for (const Triangle& t : lumen.open.triangles)
    least = std::min(least, detail::least_angle_degrees(lumen.open.vertices[std::size_t(t[0])],
                                                        lumen.open.vertices[std::size_t(t[1])],
                                                        lumen.open.vertices[std::size_t(t[2])]));
  EXPECT_GT(least, 20.0);
  EXPECT_DOUBLE_EQ(lumen.min_angle_degrees, least);
}

TEST_P(MeshLumen, HasNoSliversInItsCaps) {
  const LumenMesh& lumen = mesh();
  double least = 180.0;
  for (const Triangle& t : lumen.capped.triangles)
    least = std::min(least, detail::least_angle_degrees(lumen.capped.vertices[std::size_t(t[0])],
                                                        lumen.capped.vertices[std::size_t(t[1])],
                                                        lumen.capped.vertices[std::size_t(t[2])]));
  EXPECT_GT(least, 15.0);
  EXPECT_DOUBLE_EQ(lumen.capped_min_angle_degrees, least);
}

TEST_P(MeshLumen, LiesWithinAQuarterVoxelOfTheTruth) {
  const LumenMesh& lumen = mesh();
  std::size_t near = 0;
  const auto count = [&](const Vec3& p) {
    near += std::abs(vessel().signed_distance(p)) < 0.25 * GetParam().spacing;
  };
  for (const Vec3& p : lumen.open.vertices) count(p);
  for (const Triangle& t : lumen.open.triangles)
    count((lumen.open.vertices[std::size_t(t[0])] + lumen.open.vertices[std::size_t(t[1])] +
           lumen.open.vertices[std::size_t(t[2])]) /
          3.0);
  EXPECT_GT(double(near), 0.95 * double(lumen.open.vertices.size() + lumen.open.triangles.size()));
}

TEST_P(MeshLumen, MeasuresItsOwnQuality) {
  const LumenMesh& lumen = mesh();
  const LumenQuality& quality = lumen.quality;
  EXPECT_EQ(quality.triangle_count, int(lumen.open.triangles.size()));
  EXPECT_EQ(quality.vertex_count, int(lumen.open.vertices.size()));
  EXPECT_NEAR(quality.volume_mm3 / enclosed_volume(lumen.capped), 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(quality.min_angle_degrees, lumen.min_angle_degrees);
  EXPECT_GE(quality.min_angle_off_rims_degrees, quality.min_angle_degrees);
  EXPECT_EQ(quality.below_20_degrees + quality.below_20_degrees_at_rims, 0);
  EXPECT_EQ(std::accumulate(quality.angle_histogram.begin(), quality.angle_histogram.end(), 0),
            quality.triangle_count);
  EXPECT_LT(quality.angle_percentile_1_degrees, quality.angle_median_degrees);
  EXPECT_LT(quality.edge_min_mm, quality.edge_mean_mm);
  EXPECT_LT(quality.edge_mean_mm, quality.edge_max_mm);
  EXPECT_LT(quality.distance_percentile_95_mm, 0.25 * GetParam().spacing);
  EXPECT_LE(quality.distance_mean_mm, quality.distance_max_mm);
  EXPECT_LT(std::abs(quality.volume_change_percent), 1.0);
}

TEST_P(MeshLumen, GivesTheSameBytesTwice) {
  const LumenMesh& a = mesh();
  const LumenMesh b = mesh_lumen(vessel().level_set, vessel().tree, {});
  EXPECT_EQ(a.capped.triangles, b.capped.triangles);
  EXPECT_EQ(a.capped.vertices, b.capped.vertices);
}

INSTANTIATE_TEST_SUITE_P(Vessels, MeshLumen, testing::ValuesIn(meshed_cases()),
                         [](const auto& test_case) { return std::string(test_case.param.name); });

TEST(LumenVolume, OfATubeIsThatOfTheCylinder) {
  for (const double radius : {0.8, 1.5, 3.0}) {
    const auto vessel = test::make_tube(20.0, 0.35, [=](double) { return radius; });
    const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
    const double length = distance(cap_centre(lumen, 1), cap_centre(lumen, 2));
    EXPECT_NEAR(enclosed_volume(lumen.capped) / (pi * radius * radius * length), 1.0, 0.01);
  }
}

TEST(LumenVolume, OfABentTubeIsThatOfTheTorus) {
  const auto vessel = test::make_arc(1.5, 8.0, 2.5, 0.3);
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
  const auto angle = [](const Vec3& p) { return std::atan2(p.z, p.x); };
  const double length = 8.0 * (angle(cap_centre(lumen, 2)) - angle(cap_centre(lumen, 1)));
  EXPECT_NEAR(enclosed_volume(lumen.capped) / (pi * 1.5 * 1.5 * length), 1.0, 0.01);
}

TEST(LumenVolume, ChangeIsThatOfAShiftedLevelSet) {
  // A level set that is wrong by d moves the zero by d: the surface then encloses d * area more.
  auto vessel = test::make_tube(20.0, 0.3, [](double) { return 1.5; });
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
  const double length = distance(cap_centre(lumen, 1), cap_centre(lumen, 2));
  const double truth = pi * 1.5 * 1.5 * length;
  EXPECT_NEAR(lumen.quality.volume_change_mm3 / truth, (lumen.quality.volume_mm3 - truth) / truth,
              0.004);
}

TEST(LumenMeshing, OpensNoMoreThanOneRadiusInside) {
  const auto vessel = test::make_tube(20.0, 0.3, [](double) { return 1.5; });
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
  EXPECT_LT(cap_centre(lumen, 1).z, 1.5);
  EXPECT_GT(cap_centre(lumen, 2).z, 20.0 - 1.5);
}

TEST(LumenMeshing, EdgesFollowTheLocalRadius) {
  const auto vessel = test::make_tube(40.0, 0.3, test::stenosis(2.0, 20.0, 8.0, 0.6));
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
  const auto mean_edge_near = [&](double z) {
    double sum = 0.0;
    int count = 0;
    for (const auto& [a, b] : unique_edges(lumen.open)) {
      const Vec3& p = lumen.open.vertices[std::size_t(a)];
      const Vec3& q = lumen.open.vertices[std::size_t(b)];
      if (std::abs(p.z - z) > 1.0) continue;
      sum += distance(p, q);
      ++count;
    }
    return sum / count;
  };
  EXPECT_NEAR(mean_edge_near(20.0) / (2.0 * pi * 0.8 / 16.0), 1.0, 0.2);
  EXPECT_NEAR(mean_edge_near(6.0) / (2.0 * pi * 2.0 / 16.0), 1.0, 0.2);
}

TEST(LumenMeshing, EdgesFollowTheSurfacesOwnCurvature) {
  // An oval tube: its tips are curved four times as much as its flat sides.
  constexpr double kWide = 3.0;
  constexpr double kNarrow = 1.2;
  auto vessel = test::make_tube(20.0, 0.3, [](double) { return kNarrow; });
  const auto oval = [](const Vec3& p) {
    const double ring = std::hypot(p.x / kWide, p.y / kNarrow);
    const double slope = std::hypot(p.x / (kWide * kWide), p.y / (kNarrow * kNarrow));
    const double wall = slope > 0.0 ? (ring - 1.0) * ring / slope : -kNarrow;
    return std::max({wall, -p.z, p.z - 20.0});
  };
  vessel.level_set = test::sample_level_set({-4.0, -2.4, -1.0}, {4.0, 2.4, 21.0}, 0.3, oval);
  LumenMeshOptions options;
  options.edges_per_circumference = 24.0;
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, options);
  double tips = 0.0, sides = 0.0;
  int tip_count = 0, side_count = 0;
  for (const auto& [a, b] : unique_edges(lumen.open)) {
    const Vec3& p = lumen.open.vertices[std::size_t(a)];
    const Vec3& q = lumen.open.vertices[std::size_t(b)];
    if (std::abs(p.x) > 2.7) {
      tips += distance(p, q);
      ++tip_count;
    } else if (std::abs(p.x) < 1.0) {
      sides += distance(p, q);
      ++side_count;
    }
  }
  EXPECT_LT(tips / tip_count, 0.9 * sides / side_count);
}

TEST(LumenMeshing, KeepsAGivenEdgeLength) {
  const auto vessel = test::make_tube(20.0, 0.3, [](double) { return 1.5; });
  LumenMeshOptions options;
  options.edge_length_mm = 0.4;
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, options);
  double sum = 0.0;
  const auto edges = unique_edges(lumen.open);
  for (const auto& [a, b] : edges)
    sum += distance(lumen.open.vertices[std::size_t(a)], lumen.open.vertices[std::size_t(b)]);
  EXPECT_NEAR(sum / double(edges.size()), 0.4, 0.08);
}

TEST(LumenMeshing, WithEdgesTooLongForTheVesselIsSoundOrRefused) {
  const auto vessel = test::make_tube(10.0, 0.3, test::stenosis(1.5, 5.0, 3.0, 0.5));
  for (const double length : {1.0, 2.0, 3.0, 4.0, 5.0}) {
    LumenMeshOptions options;
    options.edge_length_mm = length;
    try {
      const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, options);
      EXPECT_TRUE(lumen.watertight) << length;
      EXPECT_EQ(lumen.self_intersection_count, 0) << length;
    } catch (const InputError& error) {
      EXPECT_GT(length, 1.5);  // a quarter of the circumference and less is no question
      EXPECT_THAT(error.what(), testing::HasSubstr("mesh.edge_length_mm"));
    }
  }
}

TEST(LumenMeshing, KeepsTheTriangleBudgetAndSaysSo) {
  const auto vessel = test::make_tube(40.0, 0.3, [](double) { return 1.5; });
  LumenMeshOptions options;
  options.edges_per_circumference = 32.0;
  options.triangle_budget = 2000;
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, options);
  EXPECT_LE(lumen.open.triangles.size(), 2000U);
  EXPECT_THAT(lumen.warnings, testing::Contains(testing::HasSubstr("budget")));
}

TEST(LumenMeshing, LeavesOutWhatTheLineDoesNotRunThrough) {
  auto vessel = test::make_tube(20.0, 0.3, [](double) { return 1.5; });
  const auto tube = vessel.signed_distance;
  const auto with_ball = [tube](const Vec3& p) {
    return std::min(tube(p), distance(p, Vec3{6.0, 0.0, 10.0}) - 2.0);
  };
  vessel.level_set = test::sample_level_set({-3.0, -3.0, -1.0}, {9.0, 3.0, 21.0}, 0.3, with_ball);
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
  for (const Vec3& p : lumen.open.vertices) EXPECT_LT(p.x, 2.0);
}

TEST(LumenMeshing, OpensAVesselThatLeavesTheVolume) {
  auto vessel = test::make_tube(20.0, 0.3, [](double) { return 1.5; });
  const auto endless = [](const Vec3& p) { return std::hypot(p.x, p.y) - 1.5; };
  vessel.level_set = test::sample_level_set({-2.5, -2.5, 0.0}, {2.5, 2.5, 20.0}, 0.31, endless);
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
  EXPECT_EQ(boundary_loops(lumen.open).size(), 2U);
  const double length = distance(cap_centre(lumen, 1), cap_centre(lumen, 2));
  EXPECT_NEAR(enclosed_volume(lumen.capped) / (pi * 1.5 * 1.5 * length), 1.0, 0.01);
}

TEST(LumenMeshing, AnEmptyLevelSetIsAnInputError) {
  auto vessel = test::make_tube(5.0, 0.5, [](double) { return 1.0; });
  for (float& value : vessel.level_set.values) value = 1.0F;
  EXPECT_THROW(mesh_lumen(vessel.level_set, vessel.tree, {}), InputError);
}

TEST(LumenMeshing, AClosedRingIsAnInputError) {
  const test::Vessel ring = test::make_arc(1.5, 6.0, 2.0 * std::numbers::pi - 0.05, 0.3);
  EXPECT_THAT([&] { mesh_lumen(ring.level_set, ring.tree, {}); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("has no end")));
  const test::Vessel almost = test::make_arc(1.5, 6.0, 2.0 * std::numbers::pi - 1.2, 0.3);
  EXPECT_NO_THROW(mesh_lumen(almost.level_set, almost.tree, {}));
}

TEST(LumenMeshing, ATreeWithoutLinesIsAnInputError) {
  const auto vessel = test::make_tube(5.0, 0.5, [](double) { return 1.0; });
  EXPECT_THROW(mesh_lumen(vessel.level_set, CenterlineTree{}, {}), InputError);
}

TEST(LumenMeshing, ALineThatIsNotANumberIsAnInputError) {
  auto vessel = test::make_tube(5.0, 0.5, [](double) { return 1.0; });
  vessel.tree.paths[0].inscribed_radius[3] = std::nan("");
  EXPECT_THROW(mesh_lumen(vessel.level_set, vessel.tree, {}), InputError);
}

TEST(LumenMeshOptions, DefaultsAreValid) { EXPECT_NO_THROW(LumenMeshOptions{}.validate()); }

TEST(LumenMeshOptions, NamesWhatIsOutOfRange) {
  LumenMeshOptions options;
  options.edges_per_circumference = 3.0;
  try {
    options.validate();
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("edges_per_circumference"));
  }
}

}  // namespace
}  // namespace angio::meshing
