#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "angiogram/working_view.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::angiogram {
namespace {

/// A line through points, 0.5 mm apart where they are straight, of one radius.
CenterlinePath line_through(std::vector<Vec3> points, double radius) {
  CenterlinePath path;
  path.points = std::move(points);
  path.abscissa = arc_length(path.points);
  path.inscribed_radius = path.equivalent_radius = std::vector<double>(path.points.size(), radius);
  path.section_area = std::vector<double>(path.points.size(), units::kPi * radius * radius);
  return path;
}

std::vector<Vec3> straight(const Vec3& from, const Vec3& to) {
  const int count = int(std::ceil(distance(from, to) / 0.5));
  std::vector<Vec3> points;
  for (int i = 0; i <= count; ++i) points.push_back(from + (double(i) / count) * (to - from));
  return points;
}

CenterlinePath straight_line(const Vec3& from, const Vec3& to, double radius) {
  return line_through(straight(from, to), radius);
}

/// 60 mm from feet to head; its middle third is looked at.
const ViewedSegment kMiddle{0, 20.0, 40.0};
CenterlinePath upright() { return straight_line({0, 0, -30}, {0, 0, 30}, 1.0); }

TEST(WorkingViewOptions, DefaultsAreValid) { EXPECT_NO_THROW(WorkingViewOptions().validate()); }

TEST(WorkingViewOptions, RefuseWhatIsOutOfRange) {
  EXPECT_THROW((WorkingViewOptions{.primary_limit_degrees = 181.0}).validate(), OptionError);
  EXPECT_THROW((WorkingViewOptions{.secondary_limit_degrees = -1.0}).validate(), OptionError);
  EXPECT_THROW((WorkingViewOptions{.overlap_weight = std::nan("")}).validate(), OptionError);
  EXPECT_THROW((WorkingViewOptions{.second_view_degrees = 91.0}).validate(), OptionError);
}

// A straight vessel is shortened by 1 - sin of its angle to the beam.
TEST(WorkingView, ForeshortensAStraightVesselByTheSineOfItsAngle) {
  const Vec3 along = normalized(Vec3{0.3, -0.8, 0.52});
  const CenterlineTree tree{{straight_line(-30.0 * along, 30.0 * along, 1.0)}};
  for (const double p : {-75.0, -10.0, 0.0, 40.0})
    for (const double s : {-40.0, 0.0, 25.0}) {
      const double cosine = dot(along, c_arm_axes({p, s}).to_detector);
      EXPECT_NEAR(judge_view(tree, kMiddle, {p, s}).foreshortening_percent,
                  100.0 * (1.0 - std::sqrt(1.0 - cosine * cosine)), 1e-6);
    }
}

// Half a circle seen along its diameter: its shadow runs up and down, 2 R long, of pi R.
TEST(WorkingView, ForeshortensHalfACircleByTheShareOfItsDiameter) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 2000; ++i) {
    const double t = units::kPi * i / 2000;
    points.push_back({20.0 * std::cos(t), 0.0, 20.0 * std::sin(t)});
  }
  const CenterlineTree tree{{line_through(points, 0.5)}};
  const ViewedSegment all{0, 0.0, tree.paths[0].abscissa.back()};
  EXPECT_NEAR(judge_view(tree, all, {90, 0}).foreshortening_percent,
              100.0 * (1.0 - 2.0 / units::kPi), 0.1);
  EXPECT_NEAR(judge_view(tree, all, {0, 0}).foreshortening_percent, 0.0, 1e-6);
}

// An ellipse of 4 by 1 mm, its long axis turned out of the patient's left-right axis by an angle:
// from the front it looks wide open, across its short axis it shows.
TEST(WorkingView, LooksWhereAFlatThroatIsNarrow) {
  for (const double turned : {0.0, 30.0, -50.0}) {
    ViewedSegment flat = kMiddle;
    flat.throat_tangent = {0, 0, 1};
    const double a = turned * units::kPi / 180.0;
    for (int i = 0; i < 60; ++i) {
      const double t = 2.0 * units::kPi * i / 60, x = 2.0 * std::cos(t), y = 0.5 * std::sin(t);
      flat.throat.push_back(
          {x * std::cos(a) - y * std::sin(a), x * std::sin(a) + y * std::cos(a), 0.0});
    }
    const WorkingView view = find_working_view({{upright()}}, flat, {});
    EXPECT_LT(view.best.throat_mm, 1.06) << turned;
    EXPECT_NEAR(judge_view({{upright()}}, flat, view.best.angles).throat_mm, view.best.throat_mm,
                1e-9);
  }
  const WorkingView round = find_working_view({{upright()}}, kMiddle, {});
  EXPECT_EQ(round.best.angles.primary_degrees, 0.0) << "nothing tells views apart: from the front";
}

TEST(WorkingView, FindsTheAnglesAtRightAnglesToAVesselInAKnownDirection) {
  for (const double p : {-50.0, 0.0, 35.0})
    for (const double s : {-30.0, 0.0, 20.0}) {
      // Of the views at right angles to this vessel p, s is the one nearest to the front.
      const CArmAxes axes = c_arm_axes({p, s});
      const Vec3 front{0, -1, 0};
      const Vec3 away = front - dot(front, axes.to_detector) * axes.to_detector;
      const Vec3 along = norm(away) > 1e-9 ? normalized(away) : axes.up;
      const CenterlineTree tree{{straight_line(-30.0 * along, 30.0 * along, 1.0)}};
      const WorkingView view = find_working_view(tree, kMiddle, {});
      EXPECT_LT(view.best.foreshortening_percent, 0.55);
      EXPECT_EQ(view.best.overlap_percent, 0.0);
      // 6 degrees nearer to the front it is foreshortened by 0.5 %: nobody tells that apart.
      const double steep = angle_between({p, s}, {}), found = angle_between(view.best.angles, {});
      EXPECT_LT(found, steep + 1.0) << p << " " << s;
      EXPECT_GT(found, steep - 7.0) << p << " " << s;
      EXPECT_LT(angle_between(view.best.angles, {p, s}), 15.0) << p << " " << s;
    }
}

TEST(WorkingView, OfAMirroredPatientIsFromTheOtherSide) {
  CenterlineTree tree{{straight_line({-10, 20, -22}, {10, -20, 22}, 1.0)}}, mirrored = tree;
  for (Vec3& point : mirrored.paths[0].points) point.x = -point.x;
  const CArmAngles a = find_working_view(tree, kMiddle, {}).best.angles,
                   b = find_working_view(mirrored, kMiddle, {}).best.angles;
  EXPECT_NE(a.primary_degrees, 0.0);
  EXPECT_EQ(a.primary_degrees, -b.primary_degrees);
  EXPECT_EQ(a.secondary_degrees, b.secondary_degrees);
}

// A vessel of radius R that crosses behind a stretch of length L hides 2 R of it.
TEST(WorkingView, AVesselThatCrossesBehindHidesItsWidth) {
  const CenterlineTree tree{{upright(), straight_line({-15, 10, 0}, {15, 10, 0}, 2.0)}};
  EXPECT_NEAR(judge_view(tree, kMiddle, {0, 0}).overlap_percent, 100.0 * 4.0 / 20.0, 2.6);
  EXPECT_EQ(judge_view(tree, kMiddle, {90, 0}).overlap_percent, 0.0);  // beside it
  // Its end is 15 mm aside: past it, at atan(15 / 10), the segment comes free.
  const WorkingView view = find_working_view(tree, kMiddle, {});
  EXPECT_LE(view.best.overlap_percent, 1.0);
  EXPECT_GT(std::abs(view.best.angles.primary_degrees), 55.0);
  EXPECT_LT(std::abs(view.best.angles.primary_degrees), 80.0);
  EXPECT_EQ(find_working_view(tree, kMiddle, {.overlap_weight = 0.0}).best.angles.primary_degrees,
            0.0);
}

TEST(WorkingView, AVesselInFrontHidesAsMuchAsOneBehind) {
  const CenterlineTree behind{{upright(), straight_line({-15, 10, 0}, {15, 10, 0}, 2.0)}};
  const CenterlineTree front{{upright(), straight_line({-15, -10, 0}, {15, -10, 0}, 2.0)}};
  EXPECT_EQ(judge_view(behind, kMiddle, {0, 0}).overlap_percent,
            judge_view(front, kMiddle, {0, 0}).overlap_percent);
}

TEST(WorkingView, ABranchHidesThePlaceWhereItLeavesOnlyIfOneLooksAlongIt) {
  CenterlinePath branch = upright();
  branch.points.resize(61);  // to the middle
  for (const Vec3& point : straight({0.5, 0, 0}, {25, 0, 0})) branch.points.push_back(point);
  const CenterlineTree tree{{upright(), line_through(branch.points, 1.0)}};
  EXPECT_EQ(judge_view(tree, kMiddle, {0, 0}).overlap_percent, 0.0);
  EXPECT_NEAR(judge_view(tree, kMiddle, {90, 0}).overlap_percent, 100.0 * 1.57 / 20.0, 3.0);
}

TEST(WorkingView, ALineThatComesBackBehindItselfHidesItself) {
  std::vector<Vec3> points = straight({0, 0, -30}, {0, 0, 30});
  for (const Vec3& point : straight({0, 0.5, 30}, {0, 12, 30})) points.push_back(point);
  for (const Vec3& point : straight({0, 12, 29.5}, {0, 12, -30})) points.push_back(point);
  const CenterlineTree tree{{line_through(points, 1.0)}};
  EXPECT_EQ(judge_view(tree, kMiddle, {0, 0}).overlap_percent, 100.0);
  EXPECT_EQ(judge_view(tree, kMiddle, {60, 0}).overlap_percent, 0.0);
}

TEST(WorkingView, StaysWithinTheReachAndNoViewOfTheMapIsBetter) {
  const CenterlineTree tree{
      {straight_line({0, -30, 0}, {0, 30, 0}, 1.0), straight_line({-15, 10, 4}, {15, 10, 0}, 2.0)}};
  const WorkingViewOptions options{.primary_limit_degrees = 31.0, .secondary_limit_degrees = 20.0};
  const WorkingView view = find_working_view(tree, kMiddle, options);
  double least = 1e9;
  for (const SeenSegment& other : view.map.views) {
    EXPECT_LE(std::abs(other.angles.primary_degrees), 31.0);
    EXPECT_LE(std::abs(other.angles.secondary_degrees), 20.0);
    least = std::min(least, other.foreshortening_percent + other.overlap_percent);
  }
  EXPECT_LE(view.best.foreshortening_percent + view.best.overlap_percent, least + 0.5);
  EXPECT_LE(std::abs(view.best.angles.primary_degrees), 31.0);
  EXPECT_EQ(view.map.views.size(),
            view.map.primary_degrees.size() * view.map.secondary_degrees.size());
  EXPECT_EQ(view.map.primary_degrees.front(), -31.0);
  EXPECT_EQ(view.map.primary_degrees.back(), 31.0);
}

TEST(WorkingView, TheSecondOneIsFarEnoughFromTheFirst) {
  const CenterlineTree tree{{upright()}};
  const WorkingView view = find_working_view(tree, kMiddle, {.second_view_degrees = 60.0});
  ASSERT_TRUE(view.has_second);
  EXPECT_GE(angle_between(view.best.angles, view.second.angles), 60.0 - 1e-9);
  EXPECT_LT(view.second.foreshortening_percent, 1.5);
  EXPECT_FALSE(find_working_view(tree, kMiddle,
                                 {.primary_limit_degrees = 10.0, .secondary_limit_degrees = 10.0})
                   .has_second);
}

TEST(WorkingView, OfNoSegmentIsRefused) {
  const CenterlineTree tree{{upright()}};
  EXPECT_THROW(find_working_view({}, kMiddle, {}), InputError);
  EXPECT_THROW(find_working_view(tree, {0, 70.0, 80.0}, {}), InputError);
  EXPECT_THROW(find_working_view(tree, {1, 0.0, 1.0}, {}), InputError);
}

}  // namespace
}  // namespace angio::angiogram
