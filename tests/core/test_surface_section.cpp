#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/surface_section.hpp"

namespace angio {
namespace {

/// An open tube along z of 4 mm, of 240 edges around, whose sections are ellipses.
TriangleMesh elliptic_tube(double half_width, double half_height, const Vec3& middle) {
  constexpr int kAround = 240, kRings = 5;
  TriangleMesh tube;
  for (int ring = 0; ring < kRings; ++ring)
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kAround;
      tube.vertices.push_back(
          middle + Vec3{half_width * std::cos(angle), half_height * std::sin(angle), ring - 2.0});
    }
  const auto at = [](int ring, int k) { return ring * kAround + k % kAround; };
  for (int ring = 0; ring + 1 < kRings; ++ring)
    for (int k = 0; k < kAround; ++k) {
      tube.triangles.push_back({at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)});
      tube.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)});
    }
  return tube;
}

TEST(SurfaceSection, OfAnEllipticTubeIsTheEllipse) {
  const Vec3 middle{3.0, -1.0, 0.0};
  const TriangleMesh tube = elliptic_tube(2.0, 1.2, middle);
  // From anywhere inside; and the widths do not depend on where from.
  for (const Vec3& aside : {Vec3{0, 0, 0}, Vec3{1.2, 0.3, 0.4}}) {
    const auto section = nearest_section(tube.triangles, tube.vertices, middle + aside, {0, 0, 1});
    ASSERT_TRUE(section);
    EXPECT_NEAR(section->area, std::numbers::pi * 2.0 * 1.2, 2e-3);
    EXPECT_NEAR(distance(section->middle, middle + Vec3{0, 0, aside.z}), 0.0, 1e-6);
    const auto widths = section_widths(*section);
    ASSERT_TRUE(widths);
    EXPECT_NEAR(widths->greatest, 4.0, 4e-3);
    EXPECT_NEAR(widths->least, 2.4, 4e-3);
    EXPECT_NEAR(widths->eccentricity(), 0.4, 2e-3);
  }
}

TEST(SurfaceSection, TheLargestCircleIsFoundHoweverTheSectionLies) {
  for (const double half_height : {2.0, 1.2, 0.5})
    for (const double turn : {0.0, 0.3, 0.3927, 1.1}) {
      TriangleMesh tube = elliptic_tube(2.0, half_height, {});
      for (Vec3& p : tube.vertices)
        p = {p.x * std::cos(turn) - p.y * std::sin(turn),
             p.x * std::sin(turn) + p.y * std::cos(turn), p.z};
      const auto section = nearest_section(tube.triangles, tube.vertices, {}, {0, 0, 1});
      ASSERT_TRUE(section && section->is_closed);
      EXPECT_NEAR(inscribed_radius(*section), half_height, 4e-3 * 2.0);
    }
}

TEST(SurfaceSection, ATiltedPlaneCutsACircleIntoAnEllipse) {
  const TriangleMesh tube = elliptic_tube(1.0, 1.0, {});
  const double tilt = 0.7;
  const auto section =
      nearest_section(tube.triangles, tube.vertices, {}, {std::sin(tilt), 0.0, std::cos(tilt)});
  ASSERT_TRUE(section);
  EXPECT_NEAR(section_widths(*section)->eccentricity(), 1.0 - std::cos(tilt), 2e-3);
}

TEST(SurfaceSection, OfTwoTubesTheNearerOneCounts) {
  TriangleMesh both = elliptic_tube(1.0, 1.0, {});
  const TriangleMesh other = elliptic_tube(0.5, 0.5, {4.0, 0.0, 0.0});
  const int shift = int(both.vertices.size());
  both.vertices.insert(both.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles)
    both.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  const auto radius = [&](const Vec3& point) {
    return std::sqrt(nearest_section(both.triangles, both.vertices, point, {0, 0, 1})->area /
                     std::numbers::pi);
  };
  EXPECT_NEAR(radius({0.9, 0.0, 0.0}), 1.0, 1e-3);
  EXPECT_NEAR(radius({3.2, 0.0, 0.0}), 0.5, 1e-3);
}

TEST(SurfaceSection, IsNothingWhereThePlaneMeetsNothing) {
  const TriangleMesh tube = elliptic_tube(1.0, 1.0, {});
  EXPECT_FALSE(nearest_section(tube.triangles, tube.vertices, {0, 0, 5.0}, {0, 0, 1}));
}

TEST(SurfaceSection, ThatIsOpenHasNoWidthsAndNoLargestCircle) {
  TriangleMesh half = elliptic_tube(1.0, 1.0, {});
  std::erase_if(half.triangles,
                [&](const Triangle& t) { return half.vertices[std::size_t(t[0])].y < -0.1; });
  const auto section = nearest_section(half.triangles, half.vertices, {}, {0, 0, 1});
  ASSERT_TRUE(section);
  EXPECT_FALSE(section_widths(*section));
  EXPECT_FALSE(section->is_closed);
  EXPECT_EQ(inscribed_radius(*section), 0.0);
  EXPECT_EQ(inscribed_radius({}), 0.0);
}

}  // namespace
}  // namespace angio
