#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

#include "core/error.hpp"
#include "meshing/wall_layers.hpp"
#include "testing/meshing/placed_balloon.hpp"
#include "testing/shapes.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

constexpr double kRatio = 0.189;
constexpr double kOuter = 1.0 / (1.0 - 2.0 * kRatio);  // outer radius / lumen radius

/// A surface taken whole as the wall's inside.
ContactRegion region_of(const TriangleMesh& mesh) {
  ContactRegion region;
  region.mesh = mesh;
  region.fixed.assign(mesh.vertices.size(), 0);
  for (const auto& loop : boundary_loops(mesh))
    for (const int v : loop) region.fixed[std::size_t(v)] = 1;
  return region;
}

/// The sum over the tetrahedra around the wedge's centre: its quadrilaterals count as two triangles
/// each, seen from both diagonals.
double volume_of(const std::vector<Vec3>& x, const std::array<int, 6>& wedge) {
  const auto at = [&](std::size_t c) { return x[std::size_t(wedge[c])]; };
  Vec3 centre;
  for (std::size_t c = 0; c < 6; ++c) centre += at(c) / 6.0;
  const auto cone = [&](std::size_t a, std::size_t b, std::size_t c) {
    return dot(cross(at(b) - at(a), at(c) - at(a)), at(a) - centre) / 6.0;
  };
  double volume = cone(0, 2, 1) + cone(3, 4, 5);
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = (a + 1) % 3;
    volume += 0.5 * (cone(a, b, b + 3) + cone(a, b + 3, a + 3));
    volume += 0.5 * (cone(a, b, a + 3) + cone(b, b + 3, a + 3));
  }
  return volume;
}

std::map<WallTissue, double> volumes_of(const WallLayers& wall) {
  std::map<WallTissue, double> volumes;
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    volumes[wall.tissue[w]] += volume_of(wall.vertices, wall.wedges[w]);
  return volumes;
}

CenterlineTree straight_line(double radius, double first, double last) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 100; ++i) points.push_back({0.0, 0.0, first + (last - first) * 0.01 * i});
  CenterlineTree tree;
  tree.paths = {test::make_path(0, points, std::vector<double>(points.size(), radius))};
  return tree;
}

/// Of the vertices off the rims that have some layers around, the share of the angle with layers.
std::vector<double> layered_angles(const ContactRegion& region, const std::set<Triangle>& layered) {
  const auto& x = region.mesh.vertices;
  std::vector<double> whole(x.size(), 0.0), with_layers(x.size(), 0.0);
  for (const Triangle& t : region.mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& at = x[std::size_t(t[k])];
      const Vec3 a = normalized(x[std::size_t(t[(k + 1) % 3])] - at),
                 b = normalized(x[std::size_t(t[(k + 2) % 3])] - at);
      const double angle = std::acos(std::clamp(dot(a, b), -1.0, 1.0));
      whole[std::size_t(t[k])] += angle;
      if (layered.count(t) > 0) with_layers[std::size_t(t[k])] += angle;
    }
  std::vector<double> shares;
  for (std::size_t v = 0; v < x.size(); ++v)
    if (region.fixed[v] == 0 && with_layers[v] > 0.0) shares.push_back(with_layers[v] / whole[v]);
  return shares;
}

/// Where there are layers they are right, and where there are none it is led.
void expect_sound(const WallLayers& wall, const ContactRegion& region) {
  const std::size_t count = region.mesh.vertices.size();
  ASSERT_EQ(wall.lumen_vertex_count, int(count));
  ASSERT_EQ(wall.vertices.size(), count * std::size_t(wall.element_layer_count + 1));
  ASSERT_EQ(wall.fixed.size(), wall.vertices.size());
  ASSERT_EQ(wall.led.size(), count);
  const std::size_t wedge_count =
      wall.outer_triangles.size() * std::size_t(wall.element_layer_count);
  ASSERT_EQ(wall.wedges.size(), wedge_count);
  std::set<Triangle> layered;
  for (const auto& w : wall.wedges) layered.insert({w[0], w[1], w[2]});
  for (const Triangle& t : region.mesh.triangles)
    EXPECT_EQ(layered.count(t) == 0, std::any_of(t.begin(), t.end(), [&](int v) {
                return wall.led[std::size_t(v)] != 0;
              }));
  for (const double share : layered_angles(region, layered)) EXPECT_GT(share, 0.3);
  ASSERT_EQ(wall.layer.size(), wedge_count);
  ASSERT_EQ(wall.tissue.size(), wedge_count);
  ASSERT_EQ(wall.axial.size(), wedge_count);
  ASSERT_EQ(wall.tissue_ratio.size(), wedge_count);
  for (const double ratio : wall.tissue_ratio) {
    EXPECT_GE(ratio, 1.0);
    EXPECT_LE(ratio, 20.0);
  }
  for (std::size_t v = 0; v < wall.vertices.size(); ++v)
    EXPECT_EQ(wall.fixed[v] != 0, region.fixed[v % count] != 0 || wall.led[v % count] != 0);
  EXPECT_TRUE(
      std::equal(region.mesh.vertices.begin(), region.mesh.vertices.end(), wall.vertices.begin()));
  double least = 1.0;
  for (const auto& wedge : wall.wedges)
    least = std::min(least, least_corner_determinant(wall.vertices, wedge));
  EXPECT_GT(least, 0.0);
  for (const Vec3& axis : wall.axial) EXPECT_NEAR(norm(axis), 1.0, 1e-9);
  EXPECT_EQ(count_self_intersections({wall.vertices, wall.outer_triangles}), 0);
}

TEST(WallLayers, OfATubeHaveTheirVolumes) {
  const double radius = 1.5, length = 10.0;
  const ContactRegion region = region_of(tests::make_tube(radius, length, 60, 48));
  const WallLayers wall = build_wall_layers(region, straight_line(radius, -5.0, 15.0), {}, {});
  expect_sound(wall, region);
  EXPECT_EQ(wall.element_layer_count, 3);
  EXPECT_THAT(wall.warnings, testing::IsEmpty());
  EXPECT_EQ(wall.outer_triangles.size(), region.mesh.triangles.size());
  const auto volumes = volumes_of(wall);
  const double thickness = radius * (kOuter - 1.0);
  const std::array<double, 3> shares{0.27 / 1.03, 0.36 / 1.03, 0.40 / 1.03};
  double inside = radius;
  for (const WallTissue tissue : {WallTissue::intima, WallTissue::media, WallTissue::adventitia}) {
    const double outside = inside + shares[std::size_t(tissue)] * thickness;
    const double volume = pi * (outside * outside - inside * inside) * length;
    EXPECT_NEAR(volumes.at(tissue) / volume, 1.0, 0.01);
    inside = outside;
  }
  EXPECT_NEAR(thickness / (2.0 * (radius + thickness)), kRatio, 1e-12);
}

TEST(WallLayers, HaveAsManyElementsAsAskedFor) {
  const ContactRegion region = region_of(tests::make_tube(1.5, 10.0, 20, 16));
  WallLayerOptions options;
  options.elements_per_layer = 2;
  const WallLayers wall = build_wall_layers(region, straight_line(1.5, -5.0, 15.0), {}, options);
  expect_sound(wall, region);
  EXPECT_EQ(wall.element_layer_count, 6);
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    EXPECT_EQ(int(wall.tissue[w]), wall.layer[w] / 2);
}

/// The wall around a balloon, with the lesion that the vessel has.
struct Walled {
  test::PlacedCase placed;
  WallLayers wall;
};
Walled around_stenosis(const WallLayerOptions& options = {}) {
  Walled walled{test::place(test::stenosed_tube(), 18.0, 8.0, 3.0), {}};
  walled.wall = build_wall_layers(walled.placed.setup.region, walled.placed.vessel.tree,
                                  {{0, 14.5, 21.5, 3.0}}, options);
  return walled;
}
/// Built once; several tests look at it.
const Walled& stenosed() {
  static const Walled kWalled = around_stenosis();
  return kWalled;
}

TEST(WallLayers, AroundAStenosisHaveTheHealthyOutside) {
  const auto& [placed, wall] = stenosed();
  expect_sound(wall, placed.setup.region);
  EXPECT_EQ(wall.element_layer_count, 5);
  const std::size_t first = wall.vertices.size() - std::size_t(wall.lumen_vertex_count);
  for (std::size_t v = first; v < wall.vertices.size(); ++v)
    EXPECT_NEAR(std::hypot(wall.vertices[v].x, wall.vertices[v].y) / (1.5 * kOuter), 1.0, 0.01);
}

TEST(WallLayers, FillANarrowLumenWithPlaque) {
  const auto& [placed, wall] = stenosed();
  const TriangleMesh& inside = placed.setup.region.mesh;
  const auto count = std::size_t(wall.lumen_vertex_count);
  for (std::size_t v = 0; v < count; ++v) {
    if (std::abs(inside.vertices[v].z - 18.0) > 2.0) continue;  // the throat
    const Vec3& healthy = wall.vertices[2 * count + v];         // outside of the plaque's elements
    EXPECT_NEAR(std::hypot(healthy.x, healthy.y), 1.5, 0.02);
  }
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    const double z = wall.vertices[std::size_t(wall.wedges[w][0])].z;
    if (wall.layer[w] >= 2) {
      EXPECT_EQ(int(wall.tissue[w]), wall.layer[w] - 2);
    } else if (std::abs(z - 18.0) < 2.0) {
      EXPECT_EQ(wall.tissue[w], WallTissue::plaque);
    } else if (std::abs(z - 18.0) > 5.5) {
      EXPECT_EQ(wall.tissue[w], WallTissue::intima);
    }
  }
}

TEST(WallLayers, HaveThePlaqueElementsAskedFor) {
  WallLayerOptions options;
  options.plaque_elements = 4;
  const auto [placed, wall] = around_stenosis(options);
  expect_sound(wall, placed.setup.region);
  EXPECT_EQ(wall.element_layer_count, 7);
}

TEST(WallLayers, WithoutALesionHaveNoPlaque) {
  const test::PlacedCase& placed = stenosed().placed;
  const WallLayers wall = build_wall_layers(placed.setup.region, placed.vessel.tree, {}, {});
  expect_sound(wall, placed.setup.region);
  EXPECT_EQ(wall.element_layer_count, 3);
}

TEST(WallLayers, PointAlongTheVessel) {
  const auto& [placed, wall] = stenosed();
  for (const Vec3& axis : wall.axial) EXPECT_GT(axis.z, 0.999);
}

/// A narrowing on one side: circles that touch the healthy one from inside at +x.
test::Vessel one_sided(double severity) {
  const auto radius = test::stenosis(1.5, 18.0, 5.0, severity);
  test::Vessel vessel = test::make_tube(36.0, 0.3, radius);
  const auto shift = [radius](double z) { return 1.5 - radius(z); };
  vessel.signed_distance = [radius, shift](const Vec3& p) {
    const double z = std::clamp(p.z, 0.0, 36.0);
    return std::max({std::hypot(p.x - shift(z), p.y) - radius(z), -p.z, p.z - 36.0});
  };
  vessel.level_set =
      test::sample_level_set({-2.4, -2.41, -0.89}, {2.4, 2.4, 36.9}, 0.3, vessel.signed_distance);
  for (Vec3& p : vessel.tree.paths[0].points) p.x = shift(p.z);
  vessel.tree.paths[0].abscissa = arc_length(vessel.tree.paths[0].points);
  return vessel;
}

TEST(WallLayers, AroundAOneSidedStenosisKeepToTheHealthyAxis) {
  const test::Vessel vessel = one_sided(0.5);
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
  const ContactRegion region = region_of(lumen.open);
  const double middle = 0.5 * vessel.tree.paths[0].abscissa.back();
  const WallLayers wall =
      build_wall_layers(region, vessel.tree, {{0, middle - 3.0, middle + 3.0, 3.0}}, {});
  expect_sound(wall, region);
  const auto count = std::size_t(wall.lumen_vertex_count);
  double thin = 10.0, thick = 0.0;
  for (std::size_t v = 0; v < count; ++v) {
    const Vec3& outside = wall.vertices[wall.vertices.size() - count + v];
    EXPECT_NEAR(std::hypot(outside.x, outside.y), 1.5 * kOuter, 0.06);
    if (std::abs(wall.vertices[v].z - 18.0) > 1.0) continue;
    thin = std::min(thin, distance(wall.vertices[v], outside));
    thick = std::max(thick, distance(wall.vertices[v], outside));
  }
  // The healthy wall on the one side; on the other, the lumen's lost diameter more.
  EXPECT_NEAR(thin, 1.5 * (kOuter - 1.0), 0.06);
  EXPECT_NEAR(thick, 1.5 * (kOuter - 1.0) + 1.5, 0.1);
}

struct Vessel {
  const char* name;
  test::Vessel (*make)();
  bool has_room;          ///< for the whole wall everywhere
  double most_led = 0.0;  ///< share of the lumen's vertices
};
class WallAround : public testing::TestWithParam<Vessel> {};

TEST_P(WallAround, IsSoundEverywhere) {
  const test::Vessel vessel = GetParam().make();
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
  const ContactRegion region = region_of(lumen.open);
  const WallLayers wall = build_wall_layers(region, vessel.tree, {}, {});
  expect_sound(wall, region);
  EXPECT_EQ(wall.warnings.empty(), GetParam().has_room);
  EXPECT_LE(double(std::count(wall.led.begin(), wall.led.end(), 1)),
            GetParam().most_led * double(wall.led.size()));
  const WallLayers again = build_wall_layers(region, vessel.tree, {}, {});
  EXPECT_EQ(wall.vertices, again.vertices);
}

INSTANTIATE_TEST_SUITE_P(
    Vessels, WallAround,
    testing::Values(
        Vessel{"Bend", [] { return test::make_arc(1.5, 7.0, 2.8, 0.3); }, true},
        // The outside of the wall, at 1.6 radii, lies beyond the bend's centre: ways turn aside.
        Vessel{"SharpBend", [] { return test::make_arc(1.5, 2.0, 2.8, 0.2); }, true},
        Vessel{"Fork", [] { return test::make_fork(1.5, 1.2, 12.0, 10.0, 0.6, 0.3); }, false},
        Vessel{"NarrowFork", [] { return test::make_fork(1.5, 1.2, 12.0, 14.0, 0.35, 0.3); }, false,
               0.02},
        Vessel{"Trifurcation",
               [] { return test::make_branching(3, 1.5, 1.0, 10.0, 10.0, 0.7, 0.3); }, false}),
    [](const testing::TestParamInfo<Vessel>& vessel) { return std::string(vessel.param.name); });

TEST(WallLayers, OfAVesselWithoutALineGoByItsOwnWidth) {
  test::Vessel vessel = test::make_fork(1.5, 0.6, 12.0, 8.0, 1.2, 0.2);
  vessel.tree.paths.pop_back();
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, {});
  const ContactRegion region = region_of(lumen.open);
  const WallLayers wall = build_wall_layers(region, vessel.tree, {}, {});
  expect_sound(wall, region);
  // Along the branch of 0.6 mm, away from the fork and from its closed end.
  const Vec3 fork{0.0, 0.0, 12.0};
  const double side = vessel.tree.paths[0].points.back().x > 0.0 ? -1.0 : 1.0;
  const Vec3 along{side * std::sin(1.2), 0.0, std::cos(1.2)};
  const auto count = std::size_t(wall.lumen_vertex_count);
  int seen = 0;
  for (std::size_t v = 0; v < count; ++v) {
    const double from_fork = dot(wall.vertices[v] - fork, along);
    if (from_fork < 5.0 || from_fork > 6.5) continue;
    const double thickness =
        distance(wall.vertices[v], wall.vertices[wall.vertices.size() - count + v]);
    EXPECT_NEAR(thickness / (0.6 * (kOuter - 1.0)), 1.0, 0.1);
    EXPECT_EQ(wall.led[v], 0);
    ++seen;
  }
  EXPECT_GT(seen, 20);
}

/// Two straight tubes side by side, and their lines.
struct NearVessels {
  TriangleMesh both;
  CenterlineTree tree;
};

NearVessels near_vessels(double radius, double gap) {
  const double apart = 2.0 * radius + gap;
  NearVessels near{tests::make_tube(radius, 10.0, 24, 16), straight_line(radius, -5.0, 15.0)};
  const TriangleMesh one = near.both;
  const int half = int(one.vertices.size());
  for (const Vec3& p : one.vertices) near.both.vertices.push_back(p + Vec3{apart, 0.0, 0.0});
  for (const Triangle& t : one.triangles)
    near.both.triangles.push_back({t[0] + half, t[1] + half, t[2] + half});
  near.tree.paths.push_back(near.tree.paths[0]);
  near.tree.paths[1].id = 1;
  for (Vec3& p : near.tree.paths[1].points) p.x += apart;
  return near;
}

TEST(WallLayers, OfTwoNearVesselsShareTheRoomBetweenThem) {
  const double radius = 1.5, gap = 0.5;
  const NearVessels near = near_vessels(radius, gap);
  const ContactRegion region = region_of(near.both);
  const WallLayers wall = build_wall_layers(region, near.tree, {}, {});
  expect_sound(wall, region);
  EXPECT_EQ(std::count(wall.led.begin(), wall.led.end(), 1), 0);
  const auto count = std::size_t(wall.lumen_vertex_count);
  for (std::size_t v = 0; v < count; ++v) {
    const Vec3& outside = wall.vertices[wall.vertices.size() - count + v];
    if (std::abs(outside.y) > 0.3) continue;
    const double past = outside.x - (radius + 0.5 * gap);  // the middle between them
    EXPECT_LT(v < count / 2 ? past : -past, 0.01);
  }
  // What has no room is in the tissue that the wedges stand for: everywhere as much as is wanted.
  const auto length = [&](int v) {
    return distance(wall.vertices[std::size_t(v)],
                    wall.vertices[wall.vertices.size() - count + std::size_t(v)]);
  };
  double most = 1.0;
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    if (wall.layer[w] != 0) continue;
    const auto& [a, b, c] = std::array{wall.wedges[w][0], wall.wedges[w][1], wall.wedges[w][2]};
    const double had = (length(a) + length(b) + length(c)) / 3.0;
    EXPECT_NEAR(wall.tissue_ratio[w] * had / (radius * (kOuter - 1.0)), 1.0, 0.15);
    most = std::max(most, wall.tissue_ratio[w]);
  }
  EXPECT_GT(most, 2.0) << "0.25 mm where 0.91 are wanted";
}

TEST(WallLayers, AreLeftOutWhereTwoVesselsTouchAndNowhereElse) {
  const double radius = 1.5;
  NearVessels near = near_vessels(radius, 0.1);
  // The second vessel runs across the first: they touch at one place alone, z = 5.
  const auto turned = [](const Vec3& p) { return Vec3{p.x, 5.0 - p.z, 5.0 + p.y}; };
  for (std::size_t v = near.both.vertices.size() / 2; v < near.both.vertices.size(); ++v)
    near.both.vertices[v] = turned(near.both.vertices[v]);
  for (Vec3& p : near.tree.paths[1].points) p = turned(p);
  const ContactRegion region = region_of(near.both);
  const WallLayers wall = build_wall_layers(region, near.tree, {}, {});
  expect_sound(wall, region);
  const Vec3 touch{radius + 0.05, 0.0, 5.0};
  for (std::size_t v = 0; v < std::size_t(wall.lumen_vertex_count); ++v) {
    const double from_touch = distance(wall.vertices[v], touch);
    if (from_touch < 0.25) {
      EXPECT_NE(wall.led[v], 0) << "vertex " << v;
    }
    if (from_touch > 2.0 * radius) {
      EXPECT_EQ(wall.led[v], 0) << "vertex " << v;
    }
  }
}

TEST(WallLayers, OfNothingAreAnInputError) {
  EXPECT_THROW(build_wall_layers({}, straight_line(1.5, 0.0, 10.0), {}, {}), InputError);
}

TEST(WallLayers, OfNonsenseAreAnInputError) {
  const ContactRegion region = region_of(tests::make_tube(1.5, 10.0, 20, 16));
  const CenterlineTree tree = straight_line(1.5, -5.0, 15.0);
  const NarrowStretch good{0, 4.0, 6.0, 3.0};
  EXPECT_NO_THROW(build_wall_layers(region, tree, {good}, {}));
  for (const NarrowStretch& bad : {NarrowStretch{7, 4.0, 6.0, 3.0}, NarrowStretch{0, 6.0, 4.0, 3.0},
                                   NarrowStretch{0, 4.0, 6.0, 0.0}})
    EXPECT_THROW(build_wall_layers(region, tree, {bad}, {}), InputError);
  EXPECT_THROW(build_wall_layers(region, straight_line(0.0, -5.0, 15.0), {}, {}), InputError);
}

TEST(WallLayers, MayBeAsThinOrThickAsTheRangeSays) {
  const ContactRegion region = region_of(tests::make_tube(1.5, 10.0, 20, 16));
  for (const double ratio : {0.02, 0.4}) {
    WallLayerOptions options;
    options.thickness_ratio = ratio;
    const WallLayers wall = build_wall_layers(region, straight_line(1.5, -5.0, 15.0), {}, options);
    expect_sound(wall, region);
    const Vec3& outside = wall.vertices.back();
    EXPECT_NEAR(std::hypot(outside.x, outside.y), 1.5 / (1.0 - 2.0 * ratio), 1e-3);
  }
}

TEST(LeastCornerDeterminant, TellsARightHandedWedge) {
  const std::vector<Vec3> x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}, {1, 0, 2}, {0, 1, 2}};
  EXPECT_DOUBLE_EQ(least_corner_determinant(x, {0, 1, 2, 3, 4, 5}), 2.0);
  EXPECT_DOUBLE_EQ(least_corner_determinant(x, {3, 4, 5, 0, 1, 2}), -2.0);
  EXPECT_DOUBLE_EQ(volume_of(x, {0, 1, 2, 3, 4, 5}), 1.0);
}

TEST(WallLayerOptions, DefaultsAreValid) { EXPECT_NO_THROW(WallLayerOptions{}.validate()); }

TEST(WallLayerOptions, NamesWhatIsOutOfRange) {
  WallLayerOptions options;
  options.thickness_ratio = 0.5;
  EXPECT_THAT([&] { options.validate(); },
              testing::ThrowsMessage<OptionError>(testing::HasSubstr("thickness_ratio")));
  options = {};
  options.plaque_elements = 1;
  EXPECT_THROW(options.validate(), OptionError);
}

}  // namespace
}  // namespace angio::meshing
