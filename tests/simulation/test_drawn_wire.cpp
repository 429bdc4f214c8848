#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "simulation/balloon_measures.hpp"
#include "simulation/bodies/drawn_wire.hpp"
#include "testing/simulation/models.hpp"

/// The guidewire where it is drawn inside a balloon that moves as it likes.
namespace angio::simulation::detail {
namespace {

constexpr double kLength = 12.0, kBalloonRadius = 0.4;
constexpr int kFrames = 40;

SimulationModel wired_balloon() {
  SimulationModel model;
  model.balloon = testing::closed_tube(kLength, 30, 16, [](double) { return kBalloonRadius; });
  for (int i = 0; i < 24; ++i) model.guidewire.push_back({0, 0, kLength * (i / 23.0 - 0.5)});
  return model;
}

/// Where a vertex lies once a share of the motion is done.
using Shape = std::function<Vec3(const Vec3& start, double share)>;

/// The most that the wire turns from one segment to the next [degrees].
double sharpest_turn(const std::vector<Vec3>& wire) {
  double most = 0.0;
  for (std::size_t i = 1; i + 1 < wire.size(); ++i) {
    const Vec3 a = wire[i] - wire[i - 1], b = wire[i + 1] - wire[i];
    most = std::max(most, std::atan2(norm(cross(a, b)), dot(a, b)) * 180.0 / units::kPi);
  }
  return most;
}

void expect_inside(const SimulationModel& model, const std::vector<Vec3>& x,
                   const std::vector<Vec3>& wire, int frame) {
  const int pole = int(x.size()) - 2;
  for (std::size_t i = 0; i + 1 < wire.size(); ++i) {
    if (i > 0) {
      EXPECT_TRUE(encloses(model.balloon.triangles, x, wire[i])) << frame << ' ' << i;
    }
    for (const Triangle& t : model.balloon.triangles) {
      if (std::any_of(t.begin(), t.end(), [&](int v) { return v >= pole; })) continue;
      EXPECT_FALSE(runs_through(wire[i], wire[i + 1],
                                {x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])]}))
          << frame << ' ' << i;
    }
  }
}

/// The wire after the motion, which it has followed frame by frame inside the balloon.
std::vector<Vec3> followed(const SimulationModel& model, const Shape& shape) {
  DrawnWire wire(model, {});
  std::vector<Vec3> nodes;
  for (int frame = 0; frame <= kFrames; ++frame) {
    std::vector<Vec3> x = model.balloon.vertices;
    for (Vec3& p : x) p = shape(p, double(frame) / kFrames);
    nodes = wire.follow(x);
    EXPECT_EQ(nodes.size(), model.guidewire.size());
    expect_inside(model, x, nodes, frame);
    EXPECT_LT(distance(nodes.front(), x[x.size() - 2]), 1e-12);
    EXPECT_LT(distance(nodes.back(), x.back()), 1e-12);
  }
  return nodes;
}

TEST(DrawnWire, StaysStraightInABalloonThatFills) {
  const SimulationModel model = wired_balloon();
  const auto nodes = followed(model, [](const Vec3& p, double s) {
    return Vec3{(1.0 + 3.0 * s) * p.x, (1.0 + 3.0 * s) * p.y, p.z};
  });
  for (std::size_t i = 0; i < nodes.size(); ++i)
    EXPECT_LT(distance(nodes[i], model.guidewire[i]), 1e-6) << i;
}

TEST(DrawnWire, GoesWithABalloonThatIsCarriedAway) {
  const SimulationModel model = wired_balloon();
  const Vec3 by{5.0, -3.0, 2.0};
  const auto nodes = followed(model, [&](const Vec3& p, double s) { return p + s * by; });
  for (std::size_t i = 0; i < nodes.size(); ++i)
    EXPECT_LT(distance(nodes[i], model.guidewire[i] + by), 1e-6) << i;
}

// The layers lie 0.08 mm apart. Midway between them the barrier of both is the same; the wire's
// stiffness against the bends at both ends may push it half the way to one of them.
TEST(DrawnWire, LiesMidwayBetweenTwoLayers) {
  const SimulationModel model = wired_balloon();
  constexpr double kAside = 0.25, kFlat = 0.1;
  const auto nodes = followed(model, [](const Vec3& p, double s) {
    const double u = std::clamp((std::abs(p.z) - 3.0) / 2.5, 0.0, 1.0);
    const double w = s * (1.0 - u * u * (3.0 - 2.0 * u));
    return Vec3{kAside * w + p.x * (1.0 - (1.0 - kFlat) * w), p.y, p.z};
  });
  for (const Vec3& p : nodes) {
    if (std::abs(p.z) < 2.0) {
      EXPECT_NEAR(p.x, kAside, 0.5 * kFlat * kBalloonRadius) << p.z;
    }
  }
}

// A flat balloon that is bent around its own axis: the middle of a section lies outside.
TEST(DrawnWire, StaysInABalloonThatFoldsToAC) {
  const SimulationModel model = wired_balloon();
  const auto nodes = followed(model, [](const Vec3& p, double s) {
    const double bend = 3.0 * s, thin = (1.0 - 0.75 * s) * p.y;
    if (s == 0.0) return p;
    const double r = 1.0 / bend + thin;
    return Vec3{r * std::sin(bend * p.x), r * std::cos(bend * p.x) - 1.0 / bend, p.z};
  });
  EXPECT_LT(sharpest_turn(nodes), 30.0);
}

// As a stocking is rolled back over itself: what was around a node lies behind what was around the
// one before it.
TEST(DrawnWire, DoesNotFoldBackWhereTheMembraneDoes) {
  const SimulationModel model = wired_balloon();
  const auto nodes = followed(model, [](const Vec3& p, double s) {
    const double wide = 1.0 + 0.5 * s * std::tanh(3.0 * p.z);
    return Vec3{wide * p.x, wide * p.y, p.z - 2.2 * s * p.z * std::exp(-p.z * p.z)};
  });
  EXPECT_LT(sharpest_turn(nodes), 5.0);
  for (std::size_t i = 1; i < nodes.size(); ++i) EXPECT_GT(nodes[i].z, nodes[i - 1].z) << i;
}

// The middle is pushed aside by twice the balloon's width, over a length of that: its sections are
// sheared by 60 degrees, the wire takes the shortest way.
TEST(DrawnWire, RoundsTheCornersOfABalloonThatIsPushedAside) {
  const SimulationModel model = wired_balloon();
  const auto nodes = followed(model, [](const Vec3& p, double s) {
    const double u = std::clamp((std::abs(p.z) - 1.0) / 1.6, 0.0, 1.0);
    return Vec3{p.x + 4.0 * kBalloonRadius * s * (1.0 - u * u * (3.0 - 2.0 * u)), p.y, p.z};
  });
  EXPECT_LT(sharpest_turn(nodes), 30.0);
  EXPECT_GT(nodes[12].x, 3.0 * kBalloonRadius);
}

// As between the walls of a throat that lies beside the line of its vessel. The gaps are to the
// wire's axis; in the last two millimetres it leaves through the pole.
TEST(DrawnWire, WholeWidthStaysInsideWhereThereIsRoom) {
  const SimulationModel model = wired_balloon();
  const GuidewireOptions options;
  const auto bent = [](const Vec3& p, double s) {
    return Vec3{p.x + 0.6 * s * std::exp(-p.z * p.z / 6.0), p.y, p.z};
  };
  const auto nodes = followed(model, bent);
  std::vector<Vec3> x = model.balloon.vertices;
  for (Vec3& p : x) p = bent(p, 1.0);
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    if (std::max(std::abs(nodes[i].z), std::abs(nodes[i + 1].z)) > 4.0) continue;
    for (const Triangle& t : model.balloon.triangles) {
      const WireGap gap =
          wire_gap(nodes[i], nodes[i + 1],
                   {x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])]});
      EXPECT_GT(gap.distance, 0.9 * 0.5 * options.wire_diameter_mm) << i;
    }
  }
}

TEST(DrawnWire, OfNoGuidewireIsNothing) {
  SimulationModel model = wired_balloon();
  model.guidewire.clear();
  EXPECT_TRUE(DrawnWire(model, {}).follow(model.balloon.vertices).empty());
}

// ---- gaps ---------------------------------------------------------------------------------------

struct Pair {
  std::vector<Vec3> wire, wire_by, membrane, membrane_by;

  explicit Pair(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto points = [&](int count) {
      std::vector<Vec3> result;
      for (int i = 0; i < count; ++i) result.push_back({unit(random), unit(random), unit(random)});
      return result;
    };
    wire = points(2);
    wire_by = points(2);
    membrane = points(3);
    membrane_by = points(3);
  }
  [[nodiscard]] std::array<Vec3, 3> corners(double share) const {
    std::array<Vec3, 3> at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = membrane[k] + share * membrane_by[k];
    return at;
  }
  [[nodiscard]] Vec3 node(std::size_t i, double share) const {
    return wire[i] + share * wire_by[i];
  }
  [[nodiscard]] double gap(double share) const {
    return wire_gap(node(0, share), node(1, share), corners(share)).distance;
  }
};

TEST(WireGap, IsTheLeastDistanceOfAnyTwoPoints) {
  constexpr int kSteps = 60;
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Pair pair(seed);
    if (runs_through(pair.wire[0], pair.wire[1], pair.corners(0.0))) continue;
    double least = 1e300;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; j <= kSteps; ++j)
        for (int k = 0; j + k <= kSteps; ++k) {
          const double t = double(i) / kSteps, u = double(j) / kSteps, v = double(k) / kSteps;
          const Vec3 p = (1.0 - t) * pair.wire[0] + t * pair.wire[1];
          const Vec3 q =
              (1.0 - u - v) * pair.membrane[0] + u * pair.membrane[1] + v * pair.membrane[2];
          least = std::min(least, distance(p, q));
        }
    const double gap = pair.gap(0.0);
    EXPECT_LE(gap, least + 1e-12) << seed;
    EXPECT_NEAR(gap, least, 3.0 * 3.5 / kSteps) << seed;  // edges are at most 2 sqrt 3 long
  }
}

TEST(WireGap, HeadOnMotionEndsWithinTheLastTenth) {
  const std::vector<Vec3> wire{{-0.1, 0, 0.5}, {0.1, 0, 0.5}}, by{{0, 0, -1}, {0, 0, -1}};
  const std::vector<Vec3> membrane{{-2, -2, 0}, {2, -2, 0}, {0, 2, 0}}, still(3);
  const double share = free_share({wire, by, membrane, still}, {0, 1, 2}, {0, 0});
  EXPECT_GE(share, 0.45 - 1e-12);
  EXPECT_LE(share, 0.475 + 1e-12);
}

TEST(WireGap, NoMotionOfAFreeShareGoesThrough) {
  int stopped = 0, passed = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    Pair pair(seed);
    for (auto* by : {&pair.wire_by, &pair.membrane_by})
      for (Vec3& v : *by) v *= 3.0;
    if (runs_through(pair.wire[0], pair.wire[1], pair.corners(0.0))) continue;
    const double share =
        free_share({pair.wire, pair.wire_by, pair.membrane, pair.membrane_by}, {0, 1, 2}, {0, 0});
    const double start = pair.gap(0.0);
    for (int i = 0; i <= 100; ++i) {
      const double at = share * i / 100;
      EXPECT_GT(pair.gap(at), 0.049 * start) << seed << ' ' << at;
      EXPECT_FALSE(runs_through(pair.node(0, at), pair.node(1, at), pair.corners(at))) << seed;
    }
    EXPECT_GT(share, 0.0) << seed;
    stopped += share < 1.0 ? 1 : 0;
    passed += share == 1.0 ? 1 : 0;
  }
  EXPECT_GT(stopped, 20);  // both happen
  EXPECT_GT(passed, 20);
}

// ---- beyond the balloon -------------------------------------------------------------------------

TEST(WholeWire, GoesAlongWithThePolesAndEndsWhereItDid) {
  SimulationModel model = wired_balloon();
  for (int i = 1; i <= 20; ++i) {
    model.guidewire_before.insert(model.guidewire_before.begin(), Vec3{0, 0, -6.0 - 0.5 * i});
    model.guidewire_behind.push_back({0, 0, 6.0 + 0.5 * i});
  }
  std::vector<Vec3> inside = model.guidewire;
  inside.back().z += 1.0;
  const WholeWire wire = whole_wire(model, inside);
  ASSERT_EQ(wire.nodes.size(), 64U);
  EXPECT_EQ(std::count(wire.in_balloon.begin(), wire.in_balloon.end(), 1), 24);
  EXPECT_EQ(wire.in_balloon[19], 0);
  EXPECT_EQ(wire.in_balloon[20], 1);
  EXPECT_EQ(wire.nodes[0].z, -16.0);
  EXPECT_EQ(wire.nodes[43].z, 7.0);
  EXPECT_NEAR(wire.nodes[63].z, 16.0, 1e-12);
  EXPECT_NEAR(wire.nodes[53].z, 11.5, 1e-12);  // half-way out: half of it
  for (std::size_t i = 44; i < 64; ++i) EXPECT_GT(wire.nodes[i].z, wire.nodes[i - 1].z) << i;
}

}  // namespace
}  // namespace angio::simulation::detail
