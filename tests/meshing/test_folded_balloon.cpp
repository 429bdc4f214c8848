#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>

#include "air_mesh/build/gap_boundary.hpp"
#include "air_mesh/build/gap_mesh.hpp"
#include "core/error.hpp"
#include "meshing/detail/balloon_shape.hpp"
#include "meshing/detail/fold_section.hpp"
#include "meshing/meshing.hpp"
#include "testing/meshing/placed_balloon.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

/// A wall that is nowhere near.
class OpenSpace final : public detail::SurfaceTarget {
 public:
  [[nodiscard]] detail::TargetSample evaluate(const Vec3&) const override {
    return {-100.0, {0.0, 0.0, 1.0}};
  }
};

enum class Line { straight, helix, arc };

CenterlinePath make_line(Line line) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 300; ++i) {
    const double s = 0.1 * i;
    if (line == Line::straight) points.push_back({0.0, 0.0, s});
    const double turn = s / std::hypot(3.0, 2.0);
    if (line == Line::helix)
      points.push_back({3.0 * std::cos(turn), 3.0 * std::sin(turn), 2.0 * turn});
    if (line == Line::arc)  // of 5 mm radius: 20 mm of it turn by 230 degrees
      points.push_back({5.0 * std::cos(s / 5.0), 0.0, 5.0 * std::sin(s / 5.0)});
  }
  const std::vector<double> radii(points.size(), 1.5);
  return test::make_path(0, std::move(points), radii);
}
/// The largest curvature of the lines above.
double curvature(Line line) {
  if (line == Line::straight) return 0.0;
  return line == Line::helix ? 3.0 / (9.0 + 4.0) : 1.0 / 5.0;
}

detail::BalloonPlan folded_plan(int folds) {
  detail::BalloonPlan plan;
  plan.rest_radius = 1.5;
  plan.cylinder_length = 14.0;
  plan.start_radius = 0.45;
  plan.middle_abscissa = 15.0;
  plan.fold_count = folds;
  plan.shaft_radius = 0.3;
  plan.fold_gap = 0.02;
  plan.ring_count = 26;
  plan.ring_vertex_count = 20;
  plan.guidewire_node_count = 24;
  return plan;
}

class FoldedBalloon : public testing::TestWithParam<std::tuple<int, Line>> {
 protected:
  FoldedBalloon()
      : balloon_(
            detail::shape_balloon(folded_plan(folds()), make_line(line()), OpenSpace{}).balloon) {}

  static int folds() { return std::get<0>(GetParam()); }
  static Line line() { return std::get<1>(GetParam()); }
  [[nodiscard]] const Vec3& start(int ring, int k) const {
    return balloon_.start.vertices[index(ring, k)];
  }
  [[nodiscard]] const Vec3& rest(int ring, int k) const { return balloon_.rest[index(ring, k)]; }
  [[nodiscard]] bool on_cylinder(int ring) const {
    const double z = rest(ring, 0).z;
    return z >= 1.5 - 1e-9 && z <= 15.5 + 1e-9;
  }
  [[nodiscard]] bool is_folded(int ring) const {
    return std::hypot(rest(ring, 0).x, rest(ring, 0).y) > 0.5 * balloon_.shaft_diameter_mm + 0.02;
  }
  /// By symmetry of the folds, the centre of a ring is the mean of its vertices.
  [[nodiscard]] Vec3 centre(int ring) const {
    Vec3 sum;
    for (int k = 0; k < count(); ++k) sum += (1.0 / count()) * start(ring, k);
    return sum;
  }
  [[nodiscard]] int count() const { return balloon_.ring_vertex_count; }
  [[nodiscard]] int rings() const { return balloon_.ring_count; }

  Balloon balloon_;

 private:
  [[nodiscard]] std::size_t index(int ring, int k) const {
    return std::size_t(ring * count() + k % count());
  }
};

TEST_P(FoldedBalloon, IsASphereThatDoesNotCrossItself) {
  const SurfaceTopology topology = surface_topology(balloon_.start);
  EXPECT_TRUE(topology.is_closed());
  EXPECT_EQ(topology.euler_number, 2);
  EXPECT_GT(enclosed_volume(balloon_.start), 0.0);
  EXPECT_EQ(count_self_intersections(balloon_.start), 0);
}

// On the shaft the folds of a balloon with cones run out in necks, without being stretched along
// the cones.
TEST_P(FoldedBalloon, WithConesDoesNotCrossItselfEither) {
  detail::BalloonPlan plan = folded_plan(folds());
  plan.ends = BalloonEnds::cones;
  plan.neck_radius = plan.shaft_radius;
  plan.ring_count = 40;
  const Balloon balloon = detail::shape_balloon(plan, make_line(line()), OpenSpace{}).balloon;
  EXPECT_TRUE(surface_topology(balloon.start).is_closed());
  EXPECT_EQ(count_self_intersections(balloon.start), 0);
}

TEST_P(FoldedBalloon, HasTheCrossingProfile) {
  EXPECT_LE(balloon_.start_diameter_mm, 0.9 + 1e-9);
  EXPECT_GT(balloon_.start_diameter_mm, 0.85);
}

TEST_P(FoldedBalloon, IsUnloadedTheNominalBalloon) {
  for (int ring = 0; ring < rings(); ++ring) {
    double area = 0.0;
    for (int k = 0; k < count(); ++k) {
      const Vec3& a = rest(ring, k);
      const Vec3& b = rest(ring, k + 1);
      area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    const double z = rest(ring, 0).z;
    const double past = std::max({0.0, 1.5 - z, z - 15.5});
    EXPECT_NEAR(area / (pi * (1.5 * 1.5 - past * past)), 1.0, 1e-5);
  }
}

TEST_P(FoldedBalloon, HasRingsAsLongAsUnloaded) {
  for (int ring = 0; ring < rings(); ++ring)
    for (int k = 0; k < count(); ++k) {
      const double ratio =
          distance(start(ring, k), start(ring, k + 1)) / distance(rest(ring, k), rest(ring, k + 1));
      EXPECT_GT(ratio, on_cylinder(ring) ? 1.0 - 1e-6 : 0.1);
      EXPECT_LT(ratio, on_cylinder(ring) ? 1.0 + 1e-6 : 1.001);
    }
}

TEST_P(FoldedBalloon, IsAsLongAsUnloadedButForTheBend) {
  const double bend = 0.5 * balloon_.start_diameter_mm * curvature(line());
  for (const auto& edge : unique_edges(balloon_.start)) {
    const auto a = std::size_t(edge[0]), b = std::size_t(edge[1]);
    const double z_a = balloon_.rest[a].z, z_b = balloon_.rest[b].z;
    if (std::min(z_a, z_b) < 1.5 - 1e-9 || std::max(z_a, z_b) > 15.5 + 1e-9) continue;
    const double ratio = distance(balloon_.start.vertices[a], balloon_.start.vertices[b]) /
                         distance(balloon_.rest[a], balloon_.rest[b]);
    EXPECT_NEAR(ratio, 1.0, bend + 0.01);
  }
}

TEST_P(FoldedBalloon, KeepsItsLayersApart) {
  const int near_crease = count() / folds() / 4;
  for (int ring = 0; ring < rings(); ++ring) {
    if (!on_cylinder(ring)) continue;
    double least = 1.0;
    for (int k = 0; k < count(); ++k)
      for (int j = 0; j < count(); ++j) {
        const int steps = std::abs(k - j);
        const int apart = std::min({steps, count() - steps, std::abs(steps - 1)});
        if (apart <= near_crease) continue;  // layers meet in creases
        least = std::min(
            least, test::distance_to_segment(start(ring, k), start(ring, j), start(ring, j + 1)));
      }
    EXPECT_GT(least, 0.02);
  }
}

TEST_P(FoldedBalloon, IsClearOfTheShaft) {
  ASSERT_GE(balloon_.guidewire.size(), 24U);
  for (int ring = 0; ring < rings(); ++ring) {
    if (!is_folded(ring)) continue;
    const Vec3 middle = centre(ring);
    for (int k = 0; k < count(); ++k)
      EXPECT_GT(test::distance_to_segment(middle, start(ring, k), start(ring, k + 1)), 0.3 + 0.015);
  }
}

TEST_P(FoldedBalloon, HasItsGuidewireInTheMiddle) {
  double farthest = 0.0;
  for (int ring = 0; ring < rings(); ++ring) {
    double nearest = 100.0;
    for (std::size_t i = 0; i + 1 < balloon_.guidewire.size(); ++i)
      nearest = std::min(nearest, test::distance_to_segment(centre(ring), balloon_.guidewire[i],
                                                            balloon_.guidewire[i + 1]));
    farthest = std::max(farthest, nearest);
  }
  EXPECT_LT(farthest, 0.02);  // chords of the guidewire
}

TEST_P(FoldedBalloon, IsTiedToTheShaftWhereItIsNoWider) {
  ASSERT_EQ(balloon_.fixed.size(), balloon_.start.vertices.size());
  for (std::size_t v = 0; v < balloon_.rest.size(); ++v)
    EXPECT_EQ(balloon_.fixed[v] != 0, std::hypot(balloon_.rest[v].x, balloon_.rest[v].y) <= 0.3);
}

/// Its angles are measured around z.
class FoldedStraightBalloon : public FoldedBalloon {};

TEST_P(FoldedStraightBalloon, IsNotTwistedOnTheMean) {
  const auto angle = [](const Vec3& p) { return std::atan2(p.y, p.x); };
  // How far the ring is turned from the unloaded one: the mean over its vertices.
  const auto mean_turn = [&](int ring) {
    double turn = angle(start(ring, 0)) - angle(rest(ring, 0));
    double sum = turn;
    for (int k = 1; k < count(); ++k) {
      turn += std::remainder(angle(start(ring, k)) - angle(start(ring, k - 1)), 2.0 * pi) -
              std::remainder(angle(rest(ring, k)) - angle(rest(ring, k - 1)), 2.0 * pi);
      sum += turn;
    }
    return sum / count();
  };
  for (int ring = 1; ring < rings(); ++ring)
    EXPECT_NEAR(std::remainder(mean_turn(ring) - mean_turn(0), 2.0 * pi), 0.0, 1e-6);
}

TEST_P(FoldedStraightBalloon, IsTheSameTurnedByAFold) {
  const double a = 2.0 * pi / folds();
  for (int ring = 0; ring < rings(); ++ring)
    for (int k = 0; k < count(); ++k) {
      const Vec3& p = start(ring, k);
      const Vec3 turned{p.x * std::cos(a) - p.y * std::sin(a),
                        p.x * std::sin(a) + p.y * std::cos(a), p.z};
      EXPECT_LT(distance(turned, start(ring, k + count() / folds())), 1e-9);
    }
}

std::string name_of(const testing::TestParamInfo<std::tuple<int, Line>>& folded) {
  constexpr std::array kLines{"Straight", "Helix", "Arc"};
  return std::to_string(std::get<0>(folded.param)) + "On" +
         kLines[std::size_t(std::get<1>(folded.param))];
}
INSTANTIATE_TEST_SUITE_P(Lines, FoldedBalloon,
                         testing::Combine(testing::Values(2, 3, 5),
                                          testing::Values(Line::straight, Line::helix, Line::arc)),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Lines, FoldedStraightBalloon,
                         testing::Combine(testing::Values(2, 3, 5),
                                          testing::Values(Line::straight)),
                         name_of);

TEST(FoldPack, HoldsThePerimeter) {
  for (const int folds : {2, 3, 5}) {
    const auto pack = detail::pack_folds(folds, 9.42, 0.32, 0.025, 0.45);
    ASSERT_TRUE(pack.has_value());
    EXPECT_NEAR(folds * (pack->outer_layer_length() + pack->inner_layer_length()), 9.42, 1e-6);
    EXPECT_NEAR(pack->outer_radius(), 0.45, 1e-6);
  }
}

TEST(FoldPack, FillsTheRingBetweenCoreAndOutside) {
  // Layers a pitch apart take an area of perimeter x pitch; the rest is the spiral's steps.
  const auto pack = detail::pack_folds(5, 30.0, 0.4, 0.02, 0.4);
  ASSERT_TRUE(pack.has_value());
  EXPECT_DOUBLE_EQ(pack->pitch, 0.02);
  const double outside = std::sqrt(0.4 * 0.4 + 30.0 * 0.02 / pi);
  EXPECT_NEAR(pack->outer_radius(), outside, 2.0 * pack->pitch);
}

TEST(FoldPack, NeedsMoreThanTheCoresPerimeter) {
  EXPECT_FALSE(detail::pack_folds(3, 2.0 * pi * 0.4, 0.4, 0.02, 0.6).has_value());
}

BalloonOptions with_folds(int folds) {
  BalloonOptions options = test::with_cones();
  options.folds = folds;
  return options;
}

TEST(PlaceFoldedBalloon, InAStenosisStaysClearAndLeavesAnAirMesh) {
  for (const int folds : {2, 3, 5}) {
    const test::PlacedCase placed =
        test::place(test::stenosed_tube(), 18.0, 8.0, 3.0, with_folds(folds));
    const Balloon& balloon = placed.setup.balloon;
    EXPECT_EQ(balloon.fold_count, folds);
    EXPECT_EQ(count_self_intersections(balloon.start), 0);
    EXPECT_EQ(count_intersections(balloon.start, placed.lumen.capped), 0);
    EXPECT_THAT(placed.setup.warnings,
                testing::Not(testing::Contains(testing::HasSubstr("need points"))));
    const auto inside = air_mesh::point_inside(balloon.start);
    ASSERT_TRUE(inside.has_value());
    EXPECT_NEAR(test::winding_number(balloon.start, *inside), 1.0, 1e-9);
    const TetMesh& air = placed.setup.air.tets;
    for (const Tet& t : air.tets)
      EXPECT_GT(tet_volume(air.vertices[std::size_t(t[0])], air.vertices[std::size_t(t[1])],
                           air.vertices[std::size_t(t[2])], air.vertices[std::size_t(t[3])]),
                0.0);
    const auto gap = air_mesh::close_region(placed.setup.region.mesh);
    ASSERT_TRUE(gap.has_value());
    EXPECT_NEAR(test::sum_of_tets(air),
                enclosed_volume(gap->shell) - enclosed_volume(balloon.start), 1e-6);
  }
}

TEST(PlaceFoldedBalloon, GoesAroundBends) {
  const test::PlacedCase placed =
      test::place(test::make_arc(1.5, 7.0, 2.8, 0.3), 9.8, 2.0, 3.0, with_folds(3));
  EXPECT_EQ(count_self_intersections(placed.setup.balloon.start), 0);
  EXPECT_EQ(count_intersections(placed.setup.balloon.start, placed.lumen.capped), 0);
}

TEST(PlaceFoldedBalloon, IsWoundMoreTightlyWhereTheLumenAsksForIt) {
  const test::PlacedCase placed =
      test::place(test::stenosed_tube(0.7), 18.0, 8.0, 3.0, with_folds(3));
  EXPECT_LT(placed.setup.balloon.start_diameter_mm, 2.0 * 0.85 * 0.45 + 1e-9);
  EXPECT_LT(placed.setup.balloon.shaft_diameter_mm, 0.6);
  EXPECT_THAT(placed.setup.warnings, testing::Contains(testing::HasSubstr("shaft")));
}

TEST(PlaceFoldedBalloon, ThatDoesNotFitIsAnInputError) {
  EXPECT_THROW(test::place(test::stenosed_tube(0.85), 18.0, 8.0, 3.0, with_folds(3)), InputError);
  BalloonOptions tiny = with_folds(5);
  tiny.nominal_diameter_mm = 0.5;
  EXPECT_THROW(test::place(test::stenosed_tube(), 18.0, 8.0, 3.0, tiny), InputError);
}

TEST(PlaceFoldedBalloon, GivesTheSameBytesTwice) {
  const auto plan = folded_plan(3);
  const auto line = make_line(Line::helix);
  EXPECT_EQ(detail::shape_balloon(plan, line, OpenSpace{}).balloon.start.vertices,
            detail::shape_balloon(plan, line, OpenSpace{}).balloon.start.vertices);
}

TEST(PlaceFoldedBalloon, TakesKnownFoldsOnly) {
  BalloonOptions options = with_folds(4);
  EXPECT_THROW(options.validate(), OptionError);
}

}  // namespace
}  // namespace angio::meshing
