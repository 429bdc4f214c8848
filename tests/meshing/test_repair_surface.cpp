#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>

#include "core/error.hpp"
#include "core/surface_rims.hpp"
#include "meshing/detail/sheets.hpp"
#include "meshing/meshing.hpp"
#include "meshing/repair_surface.hpp"
#include "testing/shapes.hpp"

/// Every defect is put into a surface whose volume is known; the repaired surface has to be
/// manifold, free of crossings, and of that volume.
namespace angio::meshing {
namespace {

using std::numbers::pi;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kTubeRadius = 1.5;
constexpr double kLength = 12.0;
constexpr int kSides = 32;
constexpr int kRings = 41;

/// A tube along z as rings of vertices, open at both ends or closed by fans.
TriangleMesh make_tube(bool closed) {
  TriangleMesh mesh;
  for (int i = 0; i < kRings; ++i)
    for (int k = 0; k < kSides; ++k) {
      const double a = 2.0 * pi * k / kSides;
      mesh.vertices.push_back(
          {kTubeRadius * std::cos(a), kTubeRadius * std::sin(a), kLength * i / (kRings - 1)});
    }
  for (int i = 0; i + 1 < kRings; ++i)
    for (int k = 0; k < kSides; ++k) {
      const int a = i * kSides + k, b = i * kSides + (k + 1) % kSides;
      mesh.triangles.push_back({a, b, b + kSides});
      mesh.triangles.push_back({a, b + kSides, a + kSides});
    }
  if (!closed) return mesh;
  const int bottom = int(mesh.vertices.size());
  mesh.vertices.push_back({0.0, 0.0, 0.0});
  mesh.vertices.push_back({0.0, 0.0, kLength});
  const int top = (kRings - 1) * kSides;
  for (int k = 0; k < kSides; ++k) {
    mesh.triangles.push_back({bottom, (k + 1) % kSides, k});
    mesh.triangles.push_back({bottom + 1, top + k, top + (k + 1) % kSides});
  }
  return mesh;
}

const double kVolume =
    0.5 * kSides * std::sin(2.0 * pi / kSides) * kTubeRadius * kTubeRadius * kLength;

std::vector<std::string> texts(const RepairedSurface& repaired) {
  std::vector<std::string> list;
  for (const SurfaceRepair& repair : repaired.repairs) list.push_back(to_text(repair));
  return list;
}

void expect_sound(const TriangleMesh& mesh) {
  const SurfaceTopology topology = surface_topology(mesh);
  EXPECT_EQ(topology.nonmanifold_edge_count, 0);
  EXPECT_EQ(topology.component_count, 1);
  EXPECT_EQ(count_self_intersections(mesh), 0);
}

void expect_sound_closed_tube(const TriangleMesh& mesh, double volume_tolerance) {
  expect_sound(mesh);
  EXPECT_TRUE(surface_topology(mesh).is_closed());
  EXPECT_EQ(surface_topology(mesh).euler_number, 2);
  EXPECT_NEAR(enclosed_volume(mesh) / kVolume, 1.0, volume_tolerance);
}

/// A triangle on the wall half way up.
constexpr std::size_t kMiddle = std::size_t(kRings / 2) * 2U * kSides + 11U;

struct Defect {
  const char* name;
  std::function<void(TriangleMesh&)> make;
  const char* repair;  ///< words that the list of repairs must hold
  double volume_tolerance = 1e-12;
};
void PrintTo(const Defect& defect, std::ostream* stream) { *stream << defect.name; }

void to_soup(TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const Triangle& t : mesh.triangles) {
    const int first = int(soup.vertices.size());
    for (const int v : t) soup.vertices.push_back(mesh.vertices[std::size_t(v)]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  mesh = soup;
}

/// Vertices of one triangle lose their connection with the other half of the tube by the width of a
/// rounding in single precision.
void round_to_single_in_one_half(TriangleMesh& mesh) {
  to_soup(mesh);
  for (std::size_t v = 0; v < mesh.vertices.size() / 2; ++v) {
    Vec3& p = mesh.vertices[v];
    p = {double(float(p.x)), double(float(p.y)), double(float(p.z))};
  }
}

void remove_wall_patch(TriangleMesh& mesh, int half_width) {
  std::set<int> gone;
  for (int i = -half_width; i < half_width; ++i)
    for (int k = -half_width; k < half_width; ++k) {
      const int quad = (kRings / 2 + i) * kSides + (5 + k + kSides) % kSides;
      gone.insert(2 * quad);
      gone.insert(2 * quad + 1);
    }
  std::vector<Triangle> kept;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!gone.contains(int(t))) kept.push_back(mesh.triangles[t]);
  mesh.triangles = kept;
}

/// A band over a hole in the wall, turned half round on its way: with it the surface has one side.
void bridge_hole_by_twisted_band(TriangleMesh& mesh) {
  remove_wall_patch(mesh, 1);
  const int below = (kRings / 2 - 1) * kSides + 4, above = (kRings / 2 + 1) * kSides + 4;
  mesh.triangles.push_back({below, below + 1, above});
  mesh.triangles.push_back({below, above, above + 1});
}

std::vector<Defect> defects_of_triangles() {
  return {{"UnstitchedSoup", to_soup, "merged"},
          {"SoupRoundedInHalf", round_to_single_in_one_half, "merged", 1e-6},
          {"TwistedBand", bridge_hole_by_twisted_band, "inside out cut out", 0.01},
          {"InsideOut",
           [](TriangleMesh& mesh) {
             for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
           },
           "turned outward"},
          {"SomeTrianglesFlipped",
           [](TriangleMesh& mesh) {
             for (std::size_t t = 0; t < mesh.triangles.size(); t += 7)
               std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
           },
           "turned like their neighbours"},
          {"RepeatedTriangles",
           [](TriangleMesh& mesh) {
             for (std::size_t t = 0; t < 30; ++t) mesh.triangles.push_back(mesh.triangles[10 * t]);
           },
           "repeated"},
          {"TrianglesWithoutArea",
           [](TriangleMesh& mesh) {
             const Triangle t = mesh.triangles[kMiddle];
             mesh.triangles.push_back({t[0], t[0], t[1]});
             mesh.triangles.push_back({t[0], t[1], t[1]});
           },
           "without area"},
          {"TJunction",
           [](TriangleMesh& mesh) {  // one triangle is split at an edge, its neighbour is not
             const Triangle t = mesh.triangles[kMiddle];
             const int v = int(mesh.vertices.size());
             mesh.vertices.push_back(
                 0.5 * (mesh.vertices[std::size_t(t[0])] + mesh.vertices[std::size_t(t[1])]));
             mesh.triangles[kMiddle] = {t[0], v, t[2]};
             mesh.triangles.push_back({v, t[1], t[2]});
           },
           "T-junction"}};
}

std::vector<Defect> defects_of_walls() {
  return {
      {"MissingTriangle",
       [](TriangleMesh& mesh) {
         mesh.triangles.erase(mesh.triangles.begin() + std::ptrdiff_t(kMiddle));
       },
       "in the wall filled"},
      {"LargeHole", [](TriangleMesh& mesh) { remove_wall_patch(mesh, 3); }, "in the wall filled",
       0.01},
      {"FinInside",
       [](TriangleMesh& mesh) {  // a sheet that hangs on an edge of the wall
         const Triangle t = mesh.triangles[kMiddle];
         mesh.vertices.push_back({0.3, 0.1, 0.5 * kLength});
         mesh.triangles.push_back({t[0], t[1], int(mesh.vertices.size()) - 1});
       },
       "on the wall cut off"},
      {"Septum",
       [](TriangleMesh& mesh) {  // a wall across the lumen
         const int ring = kRings / 2 * kSides;
         const int centre = int(mesh.vertices.size());
         mesh.vertices.push_back({0.0, 0.0, 0.5 * kLength});
         for (int k = 0; k < kSides; ++k)
           mesh.triangles.push_back({ring + k, ring + (k + 1) % kSides, centre});
       },
       "on the wall cut off"},
      {"Island",
       [](TriangleMesh& mesh) {
         const TriangleMesh ball = tests::make_sphere({6.0, 0.0, 3.0}, 0.5, 2);
         const int offset = int(mesh.vertices.size());
         mesh.vertices.insert(mesh.vertices.end(), ball.vertices.begin(), ball.vertices.end());
         for (const Triangle& t : ball.triangles)
           mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
       },
       "left out"},
      {"VertexPulledThroughTheWall",
       [](TriangleMesh& mesh) {  // a spike across the lumen and out on the other side
         const int v = mesh.triangles[kMiddle][0];
         Vec3& p = mesh.vertices[std::size_t(v)];
         p = {-1.4 * p.x, -1.4 * p.y, p.z};
       },
       "crossed itself", 0.02},
  };
}

std::vector<Defect> defects() {
  std::vector<Defect> all = defects_of_triangles();
  for (const Defect& defect : defects_of_walls()) all.push_back(defect);
  return all;
}

class RepairDefect : public testing::TestWithParam<Defect> {};

TEST_P(RepairDefect, LeavesASoundTubeAndSaysWhatWasDone) {
  TriangleMesh mesh = make_tube(true);
  GetParam().make(mesh);
  const RepairedSurface repaired = repair_surface(mesh);
  expect_sound_closed_tube(repaired.mesh, GetParam().volume_tolerance);
  EXPECT_THAT(texts(repaired), Contains(HasSubstr(GetParam().repair)));
}

TEST_P(RepairDefect, KeepsTheEndsOfAnOpenTubeOpen) {
  TriangleMesh mesh = make_tube(false);
  GetParam().make(mesh);
  const RepairedSurface repaired = repair_surface(mesh);
  expect_sound(repaired.mesh);
  const auto loops = boundary_loops(repaired.mesh);
  ASSERT_EQ(loops.size(), 2U);
  for (const auto& loop : loops) EXPECT_EQ(loop.size(), std::size_t(kSides));
}

TEST_P(RepairDefect, GivesTheSameBytesTwice) {
  TriangleMesh mesh = make_tube(true);
  GetParam().make(mesh);
  const RepairedSurface a = repair_surface(mesh);
  const RepairedSurface b = repair_surface(mesh);
  EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
}

INSTANTIATE_TEST_SUITE_P(All, RepairDefect, testing::ValuesIn(defects()),
                         [](const auto& defect) { return std::string(defect.param.name); });

TEST(RepairSurface, LeavesASoundSurfaceAsItIs) {
  for (const bool closed : {true, false}) {
    const TriangleMesh mesh = make_tube(closed);
    const RepairedSurface repaired = repair_surface(mesh);
    EXPECT_TRUE(repaired.mesh.vertices == mesh.vertices);
    EXPECT_TRUE(repaired.mesh.triangles == mesh.triangles);
    EXPECT_THAT(repaired.repairs, IsEmpty());
  }
}

// A tube drawn with a ring at each end has triangles from end to end.
TEST(RepairSurface, SplitsEdgesThatAreLongerThanTheLumenIsWide) {
  constexpr double kThin = 2.0, kLong = 60.0;
  for (const bool closed : {true, false}) {
    TriangleMesh mesh;
    for (int end = 0; end < 2; ++end)
      for (int k = 0; k < kSides; ++k) {
        const double angle = 2.0 * units::kPi * k / kSides;
        mesh.vertices.push_back({kThin * std::cos(angle), kThin * std::sin(angle), kLong * end});
      }
    for (int k = 0; k < kSides; ++k) {
      const int a = k, b = (k + 1) % kSides;
      mesh.triangles.insert(mesh.triangles.end(),
                            {{a, b, kSides + b}, {a, kSides + b, kSides + a}});
    }
    if (closed)
      for (int k = 1; k + 1 < kSides; ++k)
        mesh.triangles.insert(mesh.triangles.end(),
                              {{0, k + 1, k}, {kSides, kSides + k, kSides + k + 1}});
    const RepairedSurface repaired = repair_surface(mesh);
    EXPECT_THAT(texts(repaired), Contains(HasSubstr("longer than the lumen is wide")));
    expect_sound(repaired.mesh);
    EXPECT_EQ(boundary_loops(repaired.mesh).size(), closed ? 0U : 2U);
    EXPECT_NEAR(surface_area(repaired.mesh), surface_area(mesh), 1e-9);
    for (const auto& [a, b] : unique_edges(repaired.mesh)) {
      const Vec3 &p = repaired.mesh.vertices[std::size_t(a)],
                 &q = repaired.mesh.vertices[std::size_t(b)];
      if (p.z != q.z) {  // not in a cap, whose triangles are as they were
        EXPECT_LE(distance(p, q), 2.0 * kThin);
      }
    }
  }
}

TEST(RepairSurface, KeepsAnEndOpenBesideWhichTheWallCrossesItself) {
  TriangleMesh mesh = make_tube(false);
  const std::size_t rings = surface_rims(mesh).size();
  // A vertex of the ring next to the last is pulled out beyond the end, past its neighbours.
  const auto v = std::size_t((kRings - 2) * kSides);
  mesh.vertices[v] = mesh.vertices[v + kSides + 2] + Vec3{0.1, 0.1, 0.3};
  const RepairedSurface repaired = repair_surface(mesh);
  ASSERT_THAT(texts(repaired), Contains(HasSubstr("crossed itself")));
  EXPECT_EQ(surface_rims(repaired.mesh).size(), rings);
}

TEST(RepairSurface, KeepsTheEndOfAWallOfTwoSidesOpen) {
  // Both sides hang together at one end, and not at the other.
  TriangleMesh wall = make_tube(false);
  const int offset = int(wall.vertices.size());
  for (int v = 0; v < offset; ++v) {
    const Vec3 p = wall.vertices[std::size_t(v)];
    wall.vertices.push_back({0.8 * p.x, 0.8 * p.y, p.z});
  }
  for (std::size_t t = 0, count = wall.triangles.size(); t < count; ++t) {
    const auto [a, b, c] = wall.triangles[t];
    wall.triangles.push_back({a + offset, c + offset, b + offset});
  }
  for (int i = 0; i < kSides; ++i) {
    const int k = (i + 1) % kSides;
    wall.triangles.push_back({k, i, i + offset});
    wall.triangles.push_back({k, i + offset, k + offset});
  }
  EXPECT_EQ(surface_rims(repair_surface(wall).mesh).size(), 2U);
}

TEST(RepairSurface, UnitesTubesThatCross) {
  // Two equal round tubes at a right angle share 16/3 r^3 (Steinmetz).
  TriangleMesh mesh = make_tube(true);
  const int offset = int(mesh.vertices.size());
  const TriangleMesh other = make_tube(true);
  for (const Vec3& p : other.vertices)  // along x, through the middle; off the lattice
    mesh.vertices.push_back(
        {p.z - 0.5 * kLength + 0.013, p.x + 0.007, p.y + 0.5 * kLength + 0.011});
  for (const Triangle& t : other.triangles)
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  const RepairedSurface repaired = repair_surface(mesh);
  expect_sound(repaired.mesh);
  EXPECT_TRUE(surface_topology(repaired.mesh).is_closed());
  EXPECT_NEAR(enclosed_volume(repaired.mesh) /
                  (2.0 * kVolume - 16.0 / 3.0 * kTubeRadius * kTubeRadius * kTubeRadius),
              1.0, 0.01);
  EXPECT_THAT(texts(repaired), Contains(HasSubstr("united")));
}

/// A vessel, and beside it another of a share of its size.
TEST(RepairSurface, KeepsVesselsThatLieApart) {
  for (const double share : {1.0, 0.5, 0.1}) {
    TriangleMesh mesh = make_tube(true);
    const int offset = int(mesh.vertices.size());
    const TriangleMesh other = make_tube(true);
    for (const Vec3& p : other.vertices)
      mesh.vertices.push_back(share * p + Vec3{5.0 * kTubeRadius, 0.0, 0.0});
    for (const Triangle& t : other.triangles)
      mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    const RepairedSurface repaired = repair_surface(mesh);
    const bool is_kept = share * share > 0.05;  // of the area
    EXPECT_EQ(surface_topology(repaired.mesh).component_count, is_kept ? 2 : 1) << share;
    EXPECT_EQ(repaired.repairs.empty(), is_kept) << share;
  }
}

TEST(RepairSurface, TakesSolidsThatTouchInAnEdgeApart) {
  // Two boxes that share one edge: four triangles meet there.
  TriangleMesh mesh = tests::make_box({0.0, 0.0, 0.0}, {1.0, 1.0, 2.0});
  const TriangleMesh other = tests::make_box({1.0, 1.0, 0.0}, {1.0, 1.0, 2.0});
  const int offset = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles)
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  const RepairedSurface repaired = repair_surface(mesh);
  EXPECT_TRUE(surface_topology(repaired.mesh).is_closed());
  EXPECT_EQ(surface_topology(repaired.mesh).component_count, 1);
  EXPECT_NEAR(enclosed_volume(repaired.mesh), 2.0, 1e-12);
  EXPECT_THAT(texts(repaired), Contains(HasSubstr("left out")));
}

TEST(RepairSurface, TakesSheetsApartThatHangTogetherAtBothEndsOfAnEdge) {
  // Two cubes that touch in an edge, and hang together over and under it.
  const TriangleMesh mesh = tests::surface_of_cubes(
      {{0, 0, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 0, -1}, {1, 0, -1}, {1, 1, -1}});
  ASSERT_EQ(surface_topology(mesh).nonmanifold_edge_count, 1);
  TriangleMesh apart = mesh;
  EXPECT_GT(detail::take_sheets_apart(apart).count, 0);
  EXPECT_EQ(surface_topology(apart).nonmanifold_edge_count, 0);
  EXPECT_TRUE(surface_topology(apart).is_closed());
  EXPECT_NEAR(enclosed_volume(apart), 8.0, 1e-12);
}

TEST(RepairSurface, TakesASheetApartThatNoOtherGoesWith) {
  // The same, but one of the four triangles at the edge is missing: one is alone there.
  const TriangleMesh whole = tests::surface_of_cubes(
      {{0, 0, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 0, -1}, {1, 0, -1}, {1, 1, -1}});
  const auto is_at_edge = [&](const Triangle& t) {
    return std::ranges::count_if(t, [&](int v) {
             const Vec3& p = whole.vertices[std::size_t(v)];
             return p.x == 1.0 && p.y == 1.0 && (p.z == 0.0 || p.z == 1.0);
           }) == 2;
  };
  ASSERT_EQ(std::ranges::count_if(whole.triangles, is_at_edge), 4);
  for (std::size_t missing = 0; missing < whole.triangles.size(); ++missing) {
    if (!is_at_edge(whole.triangles[missing])) continue;
    TriangleMesh apart = whole;
    apart.triangles.erase(apart.triangles.begin() + std::ptrdiff_t(missing));
    ASSERT_EQ(surface_topology(apart).nonmanifold_edge_count, 1);
    detail::take_sheets_apart(apart);
    EXPECT_EQ(surface_topology(apart).nonmanifold_edge_count, 0) << missing;
  }
}

TEST(RepairSurface, FillsAnOpeningThatNoScanShowsBesideTheVessel) {
  // A spout of a hundredth of the tube's width and ten times as long as wide, open at its tip.
  const auto rims_with_spout = [](double radius) {
    TriangleMesh mesh = make_tube(true);
    const int top = int(mesh.vertices.size()) - 1, sides = 12;
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return t[0] == top; });
    const int rim = (kRings - 1) * kSides, spout = int(mesh.vertices.size());
    for (const double z : {kLength, kLength + 10.0 * radius, kLength + 20.0 * radius})
      for (int k = 0; k < sides; ++k) {
        const double a = 2.0 * pi * k / sides;
        mesh.vertices.push_back({radius * std::cos(a), radius * std::sin(a), z});
      }
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < sides; ++k) {
        const int a = spout + i * sides + k, b = spout + i * sides + (k + 1) % sides;
        mesh.triangles.push_back({a, b, b + sides});
        mesh.triangles.push_back({a, b + sides, a + sides});
      }
    for (int k = 0, j = 0; k < kSides; ++k) {  // the flat ring between both
      const int next_j = (k + 1) * sides / kSides;
      const int a = rim + k, b = rim + (k + 1) % kSides, c = spout + j % sides;
      mesh.triangles.push_back({a, b, c});
      if (next_j > j) mesh.triangles.push_back({b, spout + next_j % sides, c});
      j = next_j;
    }
    return boundary_loops(repair_surface(mesh).mesh).size();
  };
  EXPECT_EQ(rims_with_spout(0.2), 1U);
  EXPECT_EQ(rims_with_spout(0.01), 0U);
}

TEST(RepairSurface, RefusesByName) {
  const auto message_of = [](const TriangleMesh& mesh) -> std::string {
    try {
      repair_surface(mesh);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message_of({}), HasSubstr("no triangles"));
  TriangleMesh mesh = make_tube(true);
  mesh.vertices[3].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message_of(mesh), HasSubstr("not a number"));
  mesh = make_tube(true);
  mesh.triangles[3][1] = 1000000;
  EXPECT_THAT(message_of(mesh), HasSubstr("missing vertex"));
  mesh = {};  // a Moebius strip
  constexpr int kSteps = 40;
  for (int i = 0; i < kSteps; ++i)
    for (const double side : {-0.3, 0.3}) {
      const double a = 2.0 * pi * i / kSteps;
      const double r = 2.0 + side * std::cos(0.5 * a);
      mesh.vertices.push_back({r * std::cos(a), r * std::sin(a), side * std::sin(0.5 * a)});
    }
  for (int i = 0; i < kSteps; ++i) {
    const bool last = i + 1 == kSteps;
    const int a = 2 * i, b = 2 * i + 1;
    const int c = last ? 1 : a + 2, d = last ? 0 : b + 2;
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({b, d, c});
  }
  EXPECT_THAT(message_of(mesh), HasSubstr("one-sided"));
}

}  // namespace
}  // namespace angio::meshing
