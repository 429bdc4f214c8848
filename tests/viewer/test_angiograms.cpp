#include <gtest/gtest.h>

#include "viewer/detail/angiograms.hpp"

namespace angio::viewer::detail {
namespace {

constexpr int kPixels = 200;

/// A picture of one shade with a darker square, away from title, arrow and scale.
Angiogram make_angiogram(double ground, double square) {
  Angiogram angiogram{"Before, AP", 0.1, kPixels, std::vector<double>(kPixels * kPixels, ground)};
  for (int y = 120; y < 160; ++y)
    for (int x = 120; x < 160; ++x) angiogram.transmission[std::size_t(y * kPixels + x)] = square;
  return angiogram;
}

int grey(const Figure& figure, int x, int y) {
  return figure.picture.rgb[3 * std::size_t(y * figure.picture.width + x)];
}

TEST(Angiograms, ShareOneScaleOfGrey) {
  ReportContent content;
  content.views.angiograms = {make_angiogram(1.0, 0.6), make_angiogram(1.0, 0.2),
                              make_angiogram(0.6, 0.6)};
  const std::vector<Figure> figures = draw_angiograms(content);
  ASSERT_EQ(figures.size(), 3u);
  EXPECT_EQ(grey(figures[0], 140, 140), grey(figures[2], 140, 140));
  EXPECT_EQ(grey(figures[0], 180, 100), grey(figures[1], 180, 100));
  EXPECT_LT(grey(figures[1], 140, 140), 30);  // the darkest of all
  EXPECT_GT(grey(figures[0], 180, 100), 200);
  // Half of the way in the beam that is left is half of the way in grey.
  EXPECT_NEAR(grey(figures[0], 140, 140),
              0.5 * (grey(figures[1], 140, 140) + grey(figures[0], 180, 100)), 1.0);
}

TEST(Angiograms, OfNoViewAreNone) { EXPECT_TRUE(draw_angiograms({}).empty()); }

}  // namespace
}  // namespace angio::viewer::detail
