#include <gtest/gtest.h>

#include <utility>

#include "viewer/detail/view_map.hpp"

namespace angio::viewer::detail {
namespace {

bool has(const std::string& page, const std::string& words) {
  return page.find(words) != std::string::npos;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

angiogram::WorkingView make_view() {
  angiogram::WorkingView view;
  view.map.primary_degrees = {-60, 0, 60};
  view.map.secondary_degrees = {-30, 30};
  for (const double s : view.map.secondary_degrees)
    for (const double p : view.map.primary_degrees) view.map.views.push_back({{p, s}, 1.0, 0.0});
  view.best = view.map.views[1];
  return view;
}

TEST(ViewMap, OfOneShadeIsARectangleARowAndNamesTheBestView) {
  const std::string svg = view_map_svg(make_view());
  EXPECT_EQ(count(svg, "<rect"), 2u);
  EXPECT_FALSE(has(svg, "hatching"));
  EXPECT_TRUE(has(svg, "best: AP CAU 30"));
  EXPECT_FALSE(has(svg, "second:"));
  EXPECT_TRUE(has(svg, "RAO 60"));
  EXPECT_TRUE(has(svg, "LAO 60"));
}

TEST(ViewMap, RightIsThePatientsLeftAndUpTheHead) {
  angiogram::WorkingView view = make_view();
  const auto place = [&](double p, double s) {
    view.best.angles = {p, s};
    const std::string svg = view_map_svg(view);
    const auto at = svg.find("<circle cx=\"") + 12;
    const auto y = svg.find("cy=\"", at) + 4;
    return std::pair(std::stod(svg.substr(at)), std::stod(svg.substr(y)));
  };
  EXPECT_LT(place(-60, 0).first, place(60, 0).first);
  EXPECT_GT(place(0, -30).second, place(0, 30).second);
}

TEST(ViewMap, HatchesWhatIsOverlappedAndShadesWhatIsShortened) {
  angiogram::WorkingView view = make_view();
  view.map.views[0].overlap_percent = 30.0;
  view.map.views[5].foreshortening_percent = 60.0;
  view.second = view.map.views[2];
  view.has_second = true;
  const std::string svg = view_map_svg(view);
  EXPECT_EQ(count(svg, "<rect"), 3u);
  const auto strokes = svg.substr(svg.find("class=\"hatching\" d=\""));
  EXPECT_EQ(count(strokes.substr(0, strokes.find("/>")), "M"), 1u);
  EXPECT_TRUE(has(svg, "second: LAO 60 CAU 30"));
}

TEST(ViewMap, OfNothingIsNothing) { EXPECT_EQ(view_map_svg({}), ""); }

}  // namespace
}  // namespace angio::viewer::detail
