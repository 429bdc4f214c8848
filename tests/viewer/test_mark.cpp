#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "viewer/detail/mark.hpp"

namespace angio::viewer::detail {
namespace {

/// The distance from the ring's middle to the nearest point of the label's box.
double label_distance(const MarkRequest& request, const MarkLayout& layout) {
  const double dx = std::max(
      {layout.label_left - request.x, 0.0, request.x - layout.label_left - request.label_width});
  const double dy = std::max({layout.label_bottom - request.y, 0.0,
                              request.y - layout.label_bottom - request.label_height});
  return std::hypot(dx, dy);
}

TEST(Mark, RingAndLabelFitAnyPictureAndDoNotOverlap) {
  for (const auto& [width, height] : {std::pair{492.0, 940.0}, {820.0, 530.0}, {820.0, 940.0}})
    for (const double wanted : {5.0, 60.0, 400.0, 5000.0})
      for (double x = 0.0; x <= 1.0; x += 0.05)
        for (double y = 0.0; y <= 1.0; y += 0.05) {
          const MarkRequest request{x * width, y * height, wanted, 150.0, 18.0, 8.0, width, height};
          const MarkLayout layout = lay_out_mark(request);
          EXPECT_LT(2.0 * layout.radius, 0.5 * std::min(width, height));
          EXPECT_GE(layout.label_left, 0.0);
          EXPECT_LE(layout.label_left + request.label_width, width);
          EXPECT_GE(layout.label_bottom, 0.0);
          EXPECT_LE(layout.label_bottom + request.label_height, height);
          EXPECT_GE(label_distance(request, layout), layout.radius) << x << " " << y;
        }
}

TEST(Mark, ASmallRingIsAsWideAsWanted) {
  EXPECT_EQ(lay_out_mark({400.0, 300.0, 20.0, 100.0, 18.0, 8.0, 820.0, 600.0}).radius, 20.0);
}

TEST(Mark, TheLabelStandsOnTheSideWithMoreRoom) {
  MarkRequest request{100.0, 300.0, 20.0, 100.0, 18.0, 8.0, 820.0, 600.0};
  EXPECT_GT(lay_out_mark(request).label_left, request.x);
  request.x = 700.0;
  EXPECT_LT(lay_out_mark(request).label_left + request.label_width, request.x);
}

TEST(Mark, TheLabelOfAMarkInTheMiddleOfANarrowPictureStandsAboveIt) {
  const MarkRequest request{100.0, 200.0, 30.0, 150.0, 18.0, 8.0, 200.0, 600.0};
  const MarkLayout layout = lay_out_mark(request);
  EXPECT_GE(layout.label_bottom, request.y + layout.radius);
}

}  // namespace
}  // namespace angio::viewer::detail
