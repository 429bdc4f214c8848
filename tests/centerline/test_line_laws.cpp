#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "centerline/centerline.hpp"
#include "centerline/detail/flat_caps.hpp"
#include "centerline/detail/ridge.hpp"
#include "core/triangle_mesh.hpp"
#include "testing/centerline/shapes.hpp"
#include "testing/shapes.hpp"
#include "tests/centerline/random_trees.hpp"

// What every line is by construction, on vessels whose wall is known exactly.
namespace angio::centerline {
namespace {

using test::grid_around;
using test::level_set_of;
using test::straight_tube;
using test::Tube;

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::acos(std::clamp(dot(normalized(a), normalized(b)), -1.0, 1.0)) * 180.0 / units::kPi;
}

/// The greatest turn of a line, off its branchings, over stretches of up to a radius.
double greatest_turn(const CenterlinePath& path) {
  std::vector<char> blanked(path.points.size(), 0);
  for (const CenterlineTract& tract : path.tracts)
    if (tract.blanking)
      for (int i = tract.first_point; i <= tract.last_point; ++i) blanked[std::size_t(i)] = 1;
  double most = 0.0;
  const auto along = [&](std::size_t i) { return path.points[i + 1] - path.points[i]; };
  for (std::size_t i = 1; i + 1 < path.points.size(); ++i)
    for (std::size_t k = i; k + 1 < path.points.size() && blanked[i] == 0 && blanked[k] == 0 &&
                            path.abscissa[k] - path.abscissa[i] <= path.inscribed_radius[i];
         ++k)
      most = std::max(most, degrees_between(along(i - 1), along(k)));
  return most;
}

/// Distance to the wall of the union of tubes, negative outside.
double depth_in(const std::vector<Tube>& tubes, const Vec3& p) {
  double depth = -1e300;
  for (const Tube& tube : tubes)
    for (std::size_t s = 0; s < tube.points.size(); ++s)
      depth = std::max(depth, tube.radius[s] - distance(p, tube.points[s]));
  return depth;
}

/// Whether nothing but its own wall is around a vessel at its point i: no other vessel meets its
/// section there, and no closed end is within two diameters.
bool stands_alone(const std::vector<Tube>& tubes, const Tube& tube, std::size_t i) {
  constexpr int kAround = 16;
  if (i == 0 || i + 1 >= tube.points.size()) return false;
  const Vec3& middle = tube.points[i];
  const double radius = tube.radius[i];
  const bool is_trunk = &tube == &tubes.front();  // the others begin inside it
  if (distance(middle, tube.points.back()) < 4.0 * radius ||
      (is_trunk && distance(middle, tube.points.front()) < 4.0 * radius))
    return false;
  const Vec3 along = normalized(tube.points[i + 1] - tube.points[i - 1]);
  const Vec3 aside = any_perpendicular(along), up = cross(along, aside);
  for (const Tube& other : tubes) {
    if (&other == &tube) continue;
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2.0 * units::kPi * k / kAround;
      const test::Nearest nearest =
          nearest_on(other, middle + radius * (std::cos(angle) * aside + std::sin(angle) * up));
      if (nearest.distance < nearest.radius) return false;
    }
  }
  return true;
}

/// The least distance of a line from the wall over the vessel's radius, of the places where the
/// vessel stands alone.
double least_share_of_radius(const CenterlinePath& path, const std::vector<Tube>& tubes) {
  double least = 1.0;
  for (const Vec3& p : path.points) {
    const Tube* own = nullptr;
    test::Nearest at;
    double depth = 0.0;
    for (const Tube& tube : tubes) {
      const test::Nearest nearest = nearest_on(tube, p);
      if (nearest.radius - nearest.distance <= depth) continue;
      own = &tube;
      at = nearest;
      depth = nearest.radius - nearest.distance;
    }
    if (own == nullptr) continue;
    const auto i = std::size_t(std::lround(at.t * double(own->points.size() - 1)));
    if (stands_alone(tubes, *own, i)) least = std::min(least, depth / at.radius);
  }
  return least;
}

/// Of half axes 2 and 1, along z.
class EllipticTube final : public Wall {
 public:
  [[nodiscard]] double ray(const Vec3&, const Vec3&, double) const override { return 0.0; }
  [[nodiscard]] bool inside(const Vec3& p) const override {
    return 0.25 * p.x * p.x + p.y * p.y < 1.0;
  }
  [[nodiscard]] double depth_in_data(const Vec3&) const override { return 1e3; }
  [[nodiscard]] double resolution() const override { return 0.1; }
};

TEST(Ridge, IsNotClimbedOutOfTheLumen) {
  // Points so far apart that the wall is nearer than any of them.
  std::vector<Vec3> wall;
  for (int k = -5; k <= 5; ++k)
    for (int a = 0; a < 8; ++a)
      wall.push_back(
          {2.0 * std::cos(a * units::kPi / 4.0), std::sin(a * units::kPi / 4.0), 3.0 * k});
  const WallPoints points(wall);
  const EllipticTube tube;
  for (const Vec3& start : {Vec3{1.0, 0.0, 1.5}, Vec3{0.8, 0.85, 1.5}, Vec3{-1.7, 0.3, -1.5}})
    EXPECT_TRUE(tube.inside(deepest_in_section(start, {0, 0, 1}, 6.0, WallDistance(points), tube)))
        << start.x;
}

TEST(Ridge, IsClimbedFromBesideTheWall) {
  std::vector<Vec3> wall;  // of an elliptic tube, half axes 2 and 1
  for (int k = -100; k <= 100; ++k)
    for (int a = 0; a < 200; ++a)
      wall.push_back(
          {2.0 * std::cos(a * units::kPi / 100.0), std::sin(a * units::kPi / 100.0), 0.04 * k});
  const WallPoints points(wall);
  const WallDistance distance_to_wall(points);
  for (const Vec3& start : {Vec3{1.9, 0.0, 0.0}, Vec3{0.3, 0.95, 0.1}, Vec3{-1.2, -0.7, 0.0}}) {
    const Vec3 deepest =
        deepest_in_section(start, {0, 0, 1}, 1.0, distance_to_wall, EllipticTube());
    EXPECT_NEAR(deepest.z, start.z, 1e-12);
    // The ridge of an ellipse is the axis between its focal circles' middles: |x| <= 1.5, y = 0.
    EXPECT_NEAR(deepest.y, 0.0, 0.06) << start.x;
    EXPECT_GT(distance_to_wall.at(deepest, 1.0), 0.9);
  }
}

TEST(WallPoints, NearestIsThatOfAllPoints) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> at(-20.0, 20.0);
  std::vector<Vec3> wall;
  for (int i = 0; i < 3000; ++i) wall.push_back({at(random), at(random), 0.3 * at(random)});
  const WallPoints points(wall);
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 place{1.5 * at(random), 1.5 * at(random), at(random)};
    double nearest = 1e300;
    for (const Vec3& p : wall) nearest = std::min(nearest, distance(p, place));
    for (const double guess : {0.01, nearest, 30.0})
      EXPECT_NEAR(points.distance_to_nearest(place, guess), nearest, 1e-12);
  }
}

TEST(Ridge, RadiusAroundIsTheLesserOfBothSides) {
  Polyline line;
  for (int i = 0; i <= 100; ++i)
    line.push_back({0.0, 0.0, 0.1 * i}, i < 45 ? 2.0 : i < 55 ? 0.2 : 1.0);
  const std::vector<double> around = radius_around(line, arc_length(line.points));
  EXPECT_EQ(around[20], 2.0);
  EXPECT_EQ(around[50], 1.0);
  EXPECT_EQ(around[90], 1.0);
}

TEST(LineLaws, HoldOnRandomTrees) {
  for (unsigned seed = 31; seed < 37; ++seed) {
    const test::RandomTree tree = test::healthy_tree(seed);
    const Volume<float> level_set = level_set_of(tree.tubes, grid_around(tree.tubes, 0.3, 1.5));
    const CenterlineResult result = extract_centerline(level_set, {});
    for (const CenterlinePath& path : result.tree.paths) {
      EXPECT_LT(greatest_turn(path), 40.0) << "seed " << seed;
      for (std::size_t i = 1; i + 1 < path.points.size(); ++i) {
        EXPECT_GT(depth_in(tree.tubes, path.points[i]), 0.0) << "seed " << seed;
        EXPECT_LT(interpolate(level_set, path.points[i]), 0.0F) << "seed " << seed;
      }
    }
  }
}

TEST(LineLaws, AVesselThatStandsAloneIsFollowedInItsMiddle) {
  // In a branch's mouth no section tells the middle; beyond it the line must not run on along the
  // wall. Measured on the trees of seeds 0 to 159: every line keeps at least 0.61 of the radius.
  // On the seeds below, a line that does not climb to the ridge comes as near as 0.2 to 0.5.
  constexpr double kMiddle = 0.6;
  for (const unsigned seed : {3U, 33U, 47U, 58U}) {
    const test::RandomTree tree = test::healthy_tree(seed);
    const auto result =
        extract_centerline(level_set_of(tree.tubes, grid_around(tree.tubes, 0.3, 1.5)), {});
    EXPECT_EQ(result.tree.paths.size(), tree.tubes.size()) << "seed " << seed;
    for (const CenterlinePath& path : result.tree.paths)
      EXPECT_GT(least_share_of_radius(path, tree.tubes), kMiddle)
          << "seed " << seed << ", line " << path.id;
  }
}

TEST(LineLaws, LengthIsThatOfTheVessel) {
  // A vessel that winds, and a wall with noise: zigzags would lengthen the line.
  const Tube winding = test::make_tube(
      [](double t) {
        return Vec3{40.0 * t, 4.0 * std::sin(6.0 * t), 3.0 * std::cos(5.0 * t)};
      },
      [](double) { return 1.5; });
  Volume<float> level_set = level_set_of({winding}, grid_around({winding}, 0.3, 1.5));
  test::add_noise(level_set, 0.1, 5);
  const CenterlineResult result = extract_centerline(level_set, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  const double truth = arc_length(winding.points).back() + 2.0 * 1.5;  // and both domes
  EXPECT_NEAR(result.tree.paths[0].abscissa.back(), truth, 0.01 * truth);
}

// Round a bend of 1.2 radii a line in the middle turns by 48 degrees within a radius, more than a
// line may: it leaves the middle, but never for the inner wall, where it would turn no less.
TEST(LineLaws, RoundATightBendTheLineStaysOffTheInnerWall) {
  constexpr double kRadius = 1.8, kBend = 1.2 * kRadius;
  const Tube siphon = test::make_tube(
      [](double t) {
        const double angle = units::kPi * std::clamp(3 * t - 1, 0.0, 1.0);
        const double leg =
            t < 1.0 / 3 ? 60 * (1.0 / 3 - t) : (t > 2.0 / 3 ? 60 * (t - 2.0 / 3) : 0);
        return Vec3{kBend * std::cos(angle), kBend * std::sin(angle) - leg, 0.0};
      },
      [](double) { return kRadius; });
  const CenterlineResult result =
      extract_centerline(level_set_of({siphon}, grid_around({siphon}, 0.32, 1.5)), {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  const CenterlinePath& path = result.tree.paths[0];
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const double s = path.abscissa[i];
    if (s < 3.0 * kRadius || path.abscissa.back() - s < 3.0 * kRadius) continue;
    EXPECT_GT(path.inscribed_radius[i], 0.3 * kRadius) << s;
    EXPECT_NEAR(path.tube_radius[i], kRadius, 0.05 * kRadius) << s;
  }
  EXPECT_FALSE(find_lesions(result.tree, {}).at(0).is_stenosis);
}

// Round 108 degrees at 1.1 radii, where the middle itself turns by 52 degrees within a radius, and
// round elbows that are sharper than the vessel is wide.
TEST(LineLaws, TheLineTurnsByLessThan40DegreesWithinARadius) {
  constexpr double kRadius = 2.0, kLeg = 16.0;
  struct Elbow {
    double bend, degrees;  // its axis' radius of curvature [mm] and angle
  };
  for (const auto& [bend, degrees] :
       {Elbow{1.1 * kRadius, 108.0}, Elbow{0.5 * kRadius, 90.0}, Elbow{0.2 * kRadius, 120.0}})
    for (const double voxel : {0.3, 0.45}) {
      const double angle = degrees * units::kPi / 180.0, arc = bend * angle;
      const auto axis = [bend = bend, angle, arc](double t) {
        const double along = t * (2.0 * kLeg + arc) - kLeg;
        const double turned = std::clamp(along / bend, 0.0, angle);
        const double before = std::min(along, 0.0), behind = std::max(along - arc, 0.0);
        return Vec3{bend * std::cos(turned) - behind * std::sin(angle),
                    bend * std::sin(turned) + before + behind * std::cos(angle), 0.0};
      };
      const Tube siphon = test::make_tube(axis, [](double) { return kRadius; });
      const CenterlineResult result =
          extract_centerline(level_set_of({siphon}, grid_around({siphon}, voxel, 1.5)), {});
      ASSERT_EQ(result.tree.paths.size(), 1U);
      const CenterlinePath& path = result.tree.paths[0];
      EXPECT_LT(greatest_turn(path), 40.0) << bend << ' ' << voxel;
      for (std::size_t k = 0; k < path.points.size(); ++k)
        EXPECT_GT(depth_in({siphon}, path.points[k]), -0.01) << bend << ' ' << path.abscissa[k];
    }
}

// Cut off at the beginning of the bend, or cut from a vessel that goes on thinner, as many a
// surface is: the line knows too little vessel to be in the middle, but is no narrower there.
TEST(LineLaws, RoundATightBendAtAnOpenEndTheLumenIsAsWideAsItIs) {
  constexpr double kRadius = 2.0, kBend = 1.1 * kRadius, kLeg = 1.0, kLong = 12.0;
  const auto radius = [](double t) { return kRadius * (1.0 - 0.3 * t); };
  const Tube siphon = test::make_tube(
      [](double t) {
        const double along = t * (kLeg + units::kPi * kBend + kLong);
        const double angle = std::clamp((along - kLeg) / kBend, 0.0, units::kPi);
        const double before = std::min(along - kLeg, 0.0),
                     behind = std::max(along - kLeg - units::kPi * kBend, 0.0);
        return Vec3{kBend * std::cos(angle), kBend * std::sin(angle) + before - behind, 0.0};
      },
      radius);
  TriangleMesh open = test::surface_of(siphon, 80, 24);
  open.triangles.resize(open.triangles.size() - std::size_t(2 * 24));  // the caps
  const CenterlineResult result = extract_centerline(open, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  const CenterlinePath& path = result.tree.paths[0];
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const double truth = radius(path.abscissa[i] / path.abscissa.back());
    EXPECT_GT(path.tube_radius[i], 0.85 * truth) << path.abscissa[i];
  }
  EXPECT_FALSE(find_lesions(result.tree, {}).at(0).is_stenosis);
}

TEST(Inlet, IsTheTrunkThoughItIsTheShortestBranch) {
  // Murray: 2.5^3 = 2.1^3 + 1.86^3. The trunk is but twice as long as wide.
  const std::vector<Tube> fork = {
      straight_tube({0, 0, -10}, {0, 0, 0}, [](double) { return 2.5; }),
      straight_tube({0, 0, 0}, {14, 0, 36}, [](double) { return 2.1; }),
      straight_tube({0, 0, 0}, {-14, 0, 36}, [](double) { return 1.86; })};
  const auto result = extract_centerline(level_set_of(fork, grid_around(fork, 0.3, 1.5)), {});
  ASSERT_EQ(result.tree.paths.size(), 2U);
  for (const CenterlinePath& path : result.tree.paths) EXPECT_LT(path.points.front().z, -8.0);
}

bool says_inlet_is_uncertain(const CenterlineResult& result) {
  return test::without_inlet(result.warnings).size() < result.warnings.size();
}

TEST(Inlet, IsSaidToBeUncertainWhereTwoEndsAreAlike) {
  const auto radius = [](double) { return 2.0; };
  const std::vector<Tube> tube = {straight_tube({0, 0, -20}, {0, 0, 20}, radius)};
  EXPECT_TRUE(says_inlet_is_uncertain(
      extract_centerline(level_set_of(tube, grid_around(tube, 0.4, 1.5)), {})));
  // Murray's fork: two equal daughters, each at 37.5 degrees, cos = 2^(2/3) / 2.
  const double r = 2.5 / std::cbrt(2.0), s = std::sin(0.654), c = std::cos(0.654);
  const std::vector<Tube> fork = {
      straight_tube({0, 0, -25}, {0, 0, 0}, [](double) { return 2.5; }),
      straight_tube({0, 0, 0}, 25.0 * Vec3{s, 0, c}, [r](double) { return r; }),
      straight_tube({0, 0, 0}, 25.0 * Vec3{-s, 0, c}, [r](double) { return r; })};
  const auto result = extract_centerline(level_set_of(fork, grid_around(fork, 0.4, 1.5)), {});
  EXPECT_FALSE(says_inlet_is_uncertain(result));
  for (const CenterlinePath& path : result.tree.paths) EXPECT_LT(path.points.front().z, -22.0);
}

TEST(Inlet, OfThreeEqualTubesIsTheOneFromWhichBothOthersGoOn) {
  // The radii tell nothing (2^3 is not 2^3 + 2^3 from either end), and err by a part of a voxel.
  constexpr double kAngle = 35.0 * units::kPi / 180.0;
  for (const double turn : {0.0, 0.3, 0.7, 1.1}) {
    const auto turned = [turn](const Vec3& p) {
      return Vec3{p.x, std::cos(turn) * p.y - std::sin(turn) * p.z,
                  std::sin(turn) * p.y + std::cos(turn) * p.z};
    };
    std::vector<Tube> fork;
    for (const Vec3& end : {Vec3{0, 0, -30}, 25.0 * Vec3{0, std::sin(kAngle), std::cos(kAngle)},
                            25.0 * Vec3{0, -std::sin(kAngle), std::cos(kAngle)}})
      fork.push_back(straight_tube({0, 0, 0}, turned(end), [](double) { return 2.0; }));
    const auto result = extract_centerline(level_set_of(fork, grid_around(fork, 0.8, 2.0)), {});
    ASSERT_EQ(result.tree.paths.size(), 2U);
    EXPECT_LT(distance(result.tree.paths[0].points.front(), turned({0, 0, -32})), 3.0) << turn;
  }
}

// An arch of 20 mm that ascends over 40 mm and descends over 100 mm, where it is a little wider;
// the same in a fifth of the size is no aorta, and its wider end the likelier one.
TEST(Inlet, OfAnAorticArchIsTheEndOfItsShorterLimb) {
  const auto begins_at = [](double scale) {
    constexpr double kUp = 40.0, kRadius = 25.0, kDown = 100.0, kArc = units::kPi * kRadius;
    const auto curve = [=](double t) {
      const double s = t * (kUp + kArc + kDown), turn = (s - kUp) / kRadius;
      const Vec3 p = s < kUp          ? Vec3{0, 0, s}
                     : s < kUp + kArc ? Vec3{kRadius - kRadius * std::cos(turn), 0,
                                             kUp + kRadius * std::sin(turn)}
                                      : Vec3{2.0 * kRadius, 0, kUp - (s - kUp - kArc)};
      return scale * p;
    };
    const std::vector<Tube> arch = {
        test::make_tube(curve, [=](double t) { return scale * (10.0 + 0.6 * t); })};
    const auto result =
        extract_centerline(level_set_of(arch, grid_around(arch, 1.2 * scale, 4.0 * scale)), {});
    EXPECT_EQ(result.tree.paths.size(), 1U);
    return (1.0 / scale) * result.tree.paths.front().points.front();
  };
  EXPECT_LT(begins_at(1.0).x, 10.0);
  EXPECT_GT(begins_at(0.2).x, 40.0);
}

TEST(Inlet, IsNotTheThornOfASac) {
  // Murray's fork, from whose middle a sac twice as wide as the trunk stands out, with a thorn on
  // it.
  const double r = 1.6 / std::cbrt(2.0), s = std::sin(0.654), c = std::cos(0.654);
  const auto sac = [](double t) {
    return t < 0.6 ? 1.5 + 1.8 * std::sin(units::kPi * t / 0.6) : 0.5;
  };
  const std::vector<Tube> tree = {
      straight_tube({0, 0, -25}, {0, 0, 0}, [](double) { return 1.6; }),
      straight_tube({0, 0, 0}, 25.0 * Vec3{s, 0, c}, [r](double) { return r; }),
      straight_tube({0, 0, 0}, 25.0 * Vec3{-s, 0, c}, [r](double) { return r; }),
      straight_tube({0, 0, 0}, {0, 14, 3}, sac)};
  const auto result = extract_centerline(level_set_of(tree, grid_around(tree, 0.3, 1.5)), {});
  ASSERT_GE(result.tree.paths.size(), 2U);
  EXPECT_LT(result.tree.paths.front().points.front().z, -22.0);
}

TEST(Inlet, IsTheAorticRootThoughItIsNoEnd) {
  // A root of 24 mm, closed at both ends and no longer than wide; a left coronary with a fork, and
  // a right one.
  const auto thin = [](double) { return 1.2; };
  const std::vector<Tube> tree = {straight_tube({-4, 0, 0}, {4, 0, 0}, [](double) { return 12.0; }),
                                  straight_tube({0, 11, 0}, {6, 28, 6}, [](double) { return 1.4; }),
                                  straight_tube({6, 28, 6}, {30, 40, 12}, thin),
                                  straight_tube({6, 28, 6}, {0, 50, 14}, thin),
                                  straight_tube({0, -4, 11}, {20, -30, 30}, thin)};
  const auto result = extract_centerline(level_set_of(tree, grid_around(tree, 0.5, 2.0)), {});
  ASSERT_GE(result.tree.paths.size(), 3U);
  for (const CenterlinePath& path : result.tree.paths)
    EXPECT_LT(std::hypot(path.points.front().y, path.points.front().z), 13.0);
  EXPECT_TRUE(std::any_of(
      result.warnings.begin(), result.warnings.end(),
      [](const std::string& note) { return note.find("wide chamber") != std::string::npos; }));
}

TEST(Inlet, IsNoHoleInTheWall) {
  // Towards its far end the vessel widens to a sac, in whose wall a few triangles are missing.
  TriangleMesh mesh = tests::make_tube(1.5, 40.0, 100, 32);
  double longest = 0.0;
  for (Vec3& p : mesh.vertices) longest = std::max(longest, std::abs(p.z));
  for (Vec3& p : mesh.vertices) {
    const double wide = 1.0 + 2.0 * std::exp(-std::pow((p.z - 0.5 * longest) / 5.0, 2));
    p.x *= wide;
    p.y *= wide;
  }
  const double hole = 0.5 * longest + 1.0;
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const Vec3 middle = (mesh.vertices[std::size_t(t[0])] + mesh.vertices[std::size_t(t[1])] +
                         mesh.vertices[std::size_t(t[2])]) /
                        3.0;
    return middle.x > 0.0 && distance(middle, {middle.x, 0.0, hole}) < 0.8;
  });
  const CenterlineResult result = extract_centerline(mesh, {});
  ASSERT_EQ(result.tree.paths.size(), 2U);
  for (const CenterlinePath& path : result.tree.paths) {
    const Vec3 inlet = path.points.front();
    EXPECT_LT(std::hypot(inlet.x, inlet.y), 0.5);
  }
}

TEST(OpenRims, AreTheEndsAndLinesBeginAndEndInTheirMiddles) {
  const TriangleMesh tube = tests::make_tube(1.5, 20.0, 60, 32);
  const CenterlineResult result = extract_centerline(tube, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  std::vector<Vec3> middles;
  for (const std::vector<int>& rim : boundary_loops(tube)) {
    Vec3 middle;
    for (const int v : rim) middle += tube.vertices[std::size_t(v)] / double(rim.size());
    middles.push_back(middle);
  }
  for (const Vec3& end : {result.tree.paths[0].points.front(), result.tree.paths[0].points.back()})
    EXPECT_LT(std::min(distance(end, middles[0]), distance(end, middles[1])), 0.05);
}

}  // namespace
}  // namespace angio::centerline
