#include <gtest/gtest.h>

#include <cmath>

#include "core/centerline.hpp"
#include "core/units.hpp"

namespace angio {
namespace {

/// A helix of radius 5 mm and 4 mm of rise a turn, whose lumen tapers linearly along its arc.
CenterlinePath make_helix(int point_count) {
  CenterlinePath path;
  for (int i = 0; i < point_count; ++i) {
    const double angle = 4.0 * units::kPi * i / (point_count - 1);
    path.points.push_back(
        {5.0 * std::cos(angle), 5.0 * std::sin(angle), 4.0 * angle / (2.0 * units::kPi)});
  }
  path.abscissa = arc_length(path.points);
  for (const double s : path.abscissa) {
    path.inscribed_radius.push_back(2.0 - 0.01 * s);
    path.equivalent_radius.push_back(2.1 - 0.01 * s);
  }
  return path;
}

TEST(ArcLength, OfAHelixIsThatOfItsChordsAndTendsToTheClosedForm) {
  const int chord_count = 2000;
  const double turn = 4.0 * units::kPi / chord_count;
  const double chord =
      std::hypot(2.0 * 5.0 * std::sin(0.5 * turn), 4.0 * turn / (2.0 * units::kPi));
  const double length = arc_length(make_helix(chord_count + 1).points).back();
  EXPECT_NEAR(length, chord_count * chord, 1e-9);
  EXPECT_NEAR(length, 2.0 * std::hypot(2.0 * units::kPi * 5.0, 4.0), 1e-3);
}

TEST(ArcLength, OfNothingIsNothing) {
  EXPECT_TRUE(arc_length({}).empty());
  EXPECT_EQ(arc_length({{1, 2, 3}}), std::vector<double>{0.0});
}

TEST(Sample, LiesOnTheCurveWithItsTangentAndRadii) {
  const CenterlinePath helix = make_helix(2001);
  const double length = helix.abscissa.back();
  for (double s = 1.0; s < length - 1.0; s += 1.37) {
    const CenterlineSample at = sample(helix, s);
    const double angle = 4.0 * units::kPi * s / length;
    const Vec3 tangent =
        normalized(Vec3{-5.0 * std::sin(angle), 5.0 * std::cos(angle), 4.0 / (2.0 * units::kPi)});
    EXPECT_NEAR(std::hypot(at.point.x, at.point.y), 5.0, 1e-3);
    EXPECT_NEAR(distance(at.tangent, tangent), 0.0, 1e-3);
    EXPECT_NEAR(at.inscribed_radius, 2.0 - 0.01 * s, 1e-12);
    EXPECT_NEAR(at.equivalent_radius, 2.1 - 0.01 * s, 1e-12);
  }
}

TEST(Sample, BeyondTheEndsIsTheEndPoint) {
  const CenterlinePath helix = make_helix(101);
  EXPECT_EQ(sample(helix, -7.0).point, helix.points.front());
  EXPECT_EQ(sample(helix, helix.abscissa.back() + 7.0).point, helix.points.back());
  EXPECT_NEAR(norm(sample(helix, -7.0).tangent), 1.0, 1e-14);
}

TEST(Sample, HasNoRadiiWherePathHasNone) {
  CenterlinePath path;
  path.points = {{0, 0, 0}, {0, 0, 2}};
  path.abscissa = arc_length(path.points);
  EXPECT_EQ(sample(path, 1.0).inscribed_radius, 0.0);
  EXPECT_EQ(sample(path, 1.0).point, (Vec3{0, 0, 1}));
}

TEST(Sample, SurvivesRepeatedPoints) {
  CenterlinePath path;
  path.points = {{0, 0, 0}, {0, 0, 1}, {0, 0, 1}, {0, 0, 2}};
  path.abscissa = arc_length(path.points);
  for (const double s : {0.0, 0.5, 1.0, 1.5, 2.0})
    EXPECT_NEAR(distance(sample(path, s).point, {0, 0, s}), 0.0, 1e-15) << s;
}

TEST(Project, FindsTheAbscissaOfAPointBesideTheLine) {
  const CenterlinePath helix = make_helix(2001);
  for (double s = 0.0; s < helix.abscissa.back(); s += 2.11) {
    const CenterlineSample at = sample(helix, s);
    const Vec3 beside = at.point + 0.4 * any_perpendicular(at.tangent);
    EXPECT_NEAR(project(helix, at.point), s, 1e-9);
    EXPECT_NEAR(project(helix, beside), s, 0.02);
  }
}

TEST(Project, ClampsToTheEnds) {
  const CenterlinePath helix = make_helix(101);
  const CenterlineSample first = sample(helix, 0.0);
  const CenterlineSample last = sample(helix, helix.abscissa.back());
  EXPECT_EQ(project(helix, first.point - 0.5 * first.tangent), 0.0);
  EXPECT_EQ(project(helix, last.point + 0.5 * last.tangent), helix.abscissa.back());
}

TEST(RadiusAtEnd, IsTheVesselsAtClosedEndsToo) {
  // A tube of radius 2 with flat caps: the ball at a point is limited by tube or cap.
  CenterlinePath path;
  for (int i = 0; i <= 100; ++i) {
    path.points.push_back({0, 0, 0.2 * i});
    path.inscribed_radius.push_back(std::min({2.0, 0.2 * i, 20.0 - 0.2 * i}));
  }
  path.abscissa = arc_length(path.points);
  EXPECT_DOUBLE_EQ(radius_at_end(path, PathEnd::outlet), 2.0);
  EXPECT_DOUBLE_EQ(radius_at_end(path, PathEnd::inlet), 2.0);
  // Caps that slant by 45 degrees.
  for (std::size_t i = 0; i < path.points.size(); ++i)
    path.inscribed_radius[i] = std::min(
        {2.0, std::sqrt(0.5) * path.abscissa[i], std::sqrt(0.5) * (20.0 - path.abscissa[i])});
  EXPECT_DOUBLE_EQ(radius_at_end(path, PathEnd::outlet), 2.0);
  EXPECT_DOUBLE_EQ(radius_at_end(path, PathEnd::inlet), 2.0);
}

}  // namespace
}  // namespace angio
