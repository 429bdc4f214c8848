#include <gtest/gtest.h>

#include <cmath>

#include "angiogram/cone_beam.hpp"
#include "testing/shapes.hpp"
#include "viewer/detail/xray_frames.hpp"

namespace angio::viewer::detail {
namespace {

constexpr int kPixels = 120;

/// A ball of 5 mm in the isocentre, and the shadow that the frame at an angle has of it.
XrayPicture make_picture(double primary_degrees, const TriangleMesh& ball) {
  angiogram::CArmMount mount;
  mount.columns = mount.rows = kPixels;
  mount.column_spacing_mm = mount.row_spacing_mm = 0.3;  // 0.2 mm at the isocentre
  mount.central_column = mount.central_row = 0.5 * (kPixels - 1);
  XrayPicture picture;
  picture.title = "Frame 1";
  picture.place = angiogram::c_arm_frame({primary_degrees, 0.0}, mount);
  picture.is_subtracted = true;
  for (const double chord : angiogram::chord_lengths(ball, picture.place))
    picture.attenuation.push_back(float(0.1 * chord));
  return picture;
}

bool is_outline(const Picture& picture, int x, int y) {
  const auto* rgb = &picture.rgb[3 * std::size_t(y * picture.width + x)];
  return int(rgb[0]) > int(rgb[2]) + 60;
}

TEST(XrayFrames, HaveTheOutlineAroundTheShadow) {
  ReportContent content;
  content.lumen = tests::make_sphere({}, 5.0, 5);
  content.frames = {make_picture(0.0, content.lumen), make_picture(70.0, content.lumen)};
  const std::vector<Figure> figures = draw_xray_frames(content);
  ASSERT_EQ(figures.size(), 2u);
  for (const Figure& figure : figures) {
    const Picture& picture = figure.picture;
    // The cone around the ball: tan(asin(r / SOD)) SID in pixels, in tiles of any size.
    const double middle = 0.5 * (picture.width - 1);
    const double radius = 5.0 / 0.2 * picture.width / kPixels;
    int marked = 0;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x)
        if (is_outline(picture, x, y)) {
          ++marked;
          EXPECT_NEAR(std::hypot(x - middle, y - middle), radius, 2.0);
        }
    EXPECT_GT(marked, 6 * radius);  // all around
    const auto grey = [&](double x) {
      return int(picture.rgb[3 * std::size_t(int(middle) * picture.width + int(x))]);
    };
    EXPECT_LT(grey(middle), 20);  // contrast medium is dark
    EXPECT_GT(grey(middle + 1.3 * radius), 235);
  }
}

TEST(XrayFrames, AreCutIntoASheet) {
  ReportContent content;
  content.lumen = tests::make_sphere({}, 5.0, 2);
  for (int n = 0; n < 5; ++n) content.frames.push_back(make_picture(30.0 * n, content.lumen));
  const std::vector<Figure> figures = draw_xray_frames(content);
  const Picture sheet = sheet_of(figures);
  EXPECT_GE(sheet.width, 4 * figures[0].picture.width);
  EXPECT_GE(sheet.height, 2 * figures[0].picture.height);
  EXPECT_LT(sheet.height, 3 * figures[0].picture.height);
}

TEST(XrayFrames, OfNoRunAreNone) { EXPECT_TRUE(draw_xray_frames({}).empty()); }

}  // namespace
}  // namespace angio::viewer::detail
