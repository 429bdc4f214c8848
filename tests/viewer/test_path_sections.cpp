#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "testing/viewer/report_content.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/detail/path_sections.hpp"
#include "viewer/detail/scale_length.hpp"

namespace angio::viewer::detail {
namespace {

/// A straight tube of 1.5 mm, 30 mm long, its lesion in the middle.
ReportContent make_straight() {
  const test::TubeShape shape{.depth = 0.0, .bend_mm = 0.0, .ring_vertex_count = 180};
  ReportContent content;
  content.lumen = test::make_tube(shape);
  content.tree.paths = {test::make_path(shape)};
  content.lesion_abscissa_mm = 15.2;
  return content;
}

std::vector<PathSection> sections_of(const ReportContent& content, int count) {
  const CenterlinePath& path = content.tree.paths[0];
  return path_sections(content, path, places_around_lesion(content, path, count));
}

TEST(PathSections, ReachAsFarToBothSidesAsWasMeasuredWithTheLesionInTheMiddle) {
  ReportContent content = make_straight();
  content.after.abscissa_mm = {9.2, 15.2, 19.2};
  const auto places = places_around_lesion(content, content.tree.paths[0], 5);
  const std::vector<double> expected{9.2, 12.2, 15.2, 18.2, 21.2};
  ASSERT_EQ(places.size(), expected.size());
  for (std::size_t i = 0; i < places.size(); ++i) EXPECT_NEAR(places[i], expected[i], 1e-9);
}

TEST(PathSections, StandAtRightAnglesToABentLineAndDoNotTurnAboutIt) {
  const ReportContent content = test::make_report_content();
  const auto sections = sections_of(content, 101);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const PlaneWindow& window = sections[i].window;
    const CenterlineSample at = sample(content.tree.paths[0], sections[i].abscissa_mm);
    EXPECT_NEAR(dot(window.right, at.tangent), 0.0, 1e-9);
    EXPECT_LT(distance(cross(window.right, window.down), at.tangent), 1e-9);
    const Vec3 before = sections[i > 0 ? i - 1 : 0].window.right;
    EXPECT_GT(dot(window.right, before), 0.99);
  }
}

TEST(ScaleLength, IsTheLongestRoundOneThatFits) {
  EXPECT_DOUBLE_EQ(scale_length(9.9), 5.0);
  EXPECT_DOUBLE_EQ(scale_length(10.0), 10.0);
  EXPECT_DOUBLE_EQ(scale_length(3.0), 2.0);
  EXPECT_DOUBLE_EQ(scale_length(0.3), 0.2);
}

TEST(SectionContours, OfATubeAreOneClosedCircleOfItsRadius) {
  const ReportContent content = make_straight();
  for (const PathSection& section : sections_of(content, 7)) {
    const auto contours = section_contours(content.lumen, section.window);
    ASSERT_EQ(contours.size(), 1u);
    EXPECT_LT(std::hypot(contours[0].front()[0] - contours[0].back()[0],
                         contours[0].front()[1] - contours[0].back()[1]),
              1e-6);
    double length = 0.0;
    for (std::size_t i = 0; i + 1 < contours[0].size(); ++i) {
      EXPECT_NEAR(std::hypot(contours[0][i][0], contours[0][i][1]), 1.5, 2e-3);
      length += std::hypot(contours[0][i + 1][0] - contours[0][i][0],
                           contours[0][i + 1][1] - contours[0][i][1]);
    }
    EXPECT_NEAR(length, 3.0 * units::kPi, 0.01);  // once around
  }
}

TEST(SectionContours, AreTheSameOfTheTrianglesNearby) {
  const ReportContent content = make_straight();
  const auto sections = sections_of(content, 7);
  const TriangleMesh near = near_sections(content.lumen, sections);
  EXPECT_LT(near.triangles.size(), content.lumen.triangles.size());
  for (const PathSection& section : sections) {
    const auto contours = section_contours(near, section.window);
    ASSERT_EQ(contours.size(), 1u);
    EXPECT_EQ(contours[0].size(), section_contours(content.lumen, section.window)[0].size());
  }
}

TEST(NearestEdges, AreAtTheRadiusAndOfTheNearestOfTwoVessels) {
  const ReportContent content = make_straight();
  const PlaneWindow window = sections_of(content, 3)[1].window;
  auto contours = section_contours(content.lumen, window);
  contours.push_back({{2.0, -1.0}, {2.0, 1.0}});  // a second vessel's wall, to the right
  for (const std::size_t axis : {0u, 1u}) {
    const auto edges = nearest_edges(contours, axis);
    ASSERT_TRUE(edges);
    EXPECT_NEAR((*edges)[0], -1.5, 2e-3);
    EXPECT_NEAR((*edges)[1], 1.5, 2e-3);
  }
  EXPECT_FALSE(nearest_edges({{{2.0, -1.0}, {2.0, 1.0}}}, 0));
  EXPECT_FALSE(nearest_edges({}, 1));
}

}  // namespace
}  // namespace angio::viewer::detail
