#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "formats/html.hpp"
#include "formats/text.hpp"
#include "testing/temporary_folder.hpp"
#include "viewer/detail/chart.hpp"
#include "viewer/detail/chart_labels.hpp"
#include "viewer/detail/report_charts.hpp"
#include "viewer/sweep_plot.hpp"

namespace angio::viewer::detail {
namespace {
using testing::HasSubstr;
using testing::Not;

Chart make_chart() {
  Chart chart;
  chart.title = "a title";
  chart.x_label = "x [mm]";
  chart.y_label = "y [mm]";
  chart.series = {{"line", {0, 1, 2, 3}, {1, 2, 1, 2}, 1, false}};
  return chart;
}

/// The y of each point of a path, from its first letter: "M0 7L1 7\" ...".
std::vector<double> heights_of(const std::string& path) {
  std::string numbers = path.substr(0, path.find('"'));
  for (char& letter : numbers)
    if (letter == 'M' || letter == 'L') letter = ' ';
  std::istringstream in(numbers);
  std::vector<double> heights;
  for (double x = 0.0, y = 0.0; in >> x >> y;) heights.push_back(y);
  return heights;
}

TEST(BarTicks, NameBothEnds) {
  EXPECT_EQ(bar_ticks(0.0, 535.0), (std::vector<double>{0.0, 200.0, 400.0, 535.0}));
  const std::vector<double> close = bar_ticks(0.0, 405.0);  // 400 has no room beside it
  EXPECT_EQ(close.back(), 405.0);
  EXPECT_LT(close[close.size() - 2], 400.0);
}

TEST(RoundTicks, CoverTheRangeInEqualRoundSteps) {
  for (const auto& [low, high] : std::vector<std::pair<double, double>>{
           {0, 1}, {0, 8.3}, {-3.2, 0.001}, {1e-7, 3e-7}, {0, 12345}, {14.2, 14.9}}) {
    const auto ticks = round_ticks(low, high, 6);
    ASSERT_GE(ticks.size(), 2u);
    EXPECT_LE(ticks.size(), 14u);
    EXPECT_LE(ticks.front(), low + 1e-9 * std::abs(low));
    EXPECT_GE(ticks.back(), high - 1e-9 * std::abs(high));
    const double step = ticks[1] - ticks[0];
    const double digit = step / std::pow(10.0, std::floor(std::log10(step) + 1e-9));
    EXPECT_TRUE(std::abs(digit - 1) < 1e-6 || std::abs(digit - 2) < 1e-6 ||
                std::abs(digit - 5) < 1e-6)
        << digit;
  }
}

TEST(Svg, HasAxesUnitsLegendAndHoverTitles) {
  const std::string drawing = svg(make_chart());
  for (const char* words : {"<svg", "x [mm]", "y [mm]", ">line</text>", "<title>line: 2", "</svg>"})
    EXPECT_THAT(drawing, HasSubstr(words));
}

TEST(Svg, TicksStandWhereTheyAreAskedForAsFarAsThereIsRoom) {
  Chart chart = make_chart();
  chart.x_ticks = {0.125, 1.5, 3};
  const std::string drawing = svg(chart);
  for (const char* tick : {">0.125<", ">1.5<", ">3<"}) EXPECT_THAT(drawing, HasSubstr(tick));
  EXPECT_THAT(drawing, Not(HasSubstr("tick mid\">2.0<")));
  chart.x_ticks = {0, 2.97, 2.98, 3};
  EXPECT_THAT(svg(chart), Not(HasSubstr(">2.97<")));
  EXPECT_THAT(svg(chart), HasSubstr(">3<"));
}

TEST(Svg, NotesStandBelowTheCharts) {
  const std::string file = svg_file({make_chart()}, {"a <note>"});
  EXPECT_GT(file.find("a &lt;note&gt;"), file.find("x [mm]"));
  EXPECT_THAT(svg_file({}, {"a note"}), testing::IsEmpty());
}

TEST(Svg, EscapesItsTexts) {
  Chart chart = make_chart();
  chart.title = chart.x_label = chart.series[0].label = "<b> & \"c\"";
  chart.marks = {{1, 1, "<b>", 1}};
  chart.levels = {{1, "<b>"}};
  chart.bands = {{0, 3, "<b>"}};
  EXPECT_THAT(svg(chart), Not(HasSubstr("<b>")));
}

TEST(Svg, WhatIsNotANumberBreaksTheLine) {
  Chart chart = make_chart();
  EXPECT_EQ(svg(chart).find('M', svg(chart).find("<path d=\"M") + 10), std::string::npos);
  chart.series[0].y = {1, std::numeric_limits<double>::quiet_NaN(), 2, 2};
  const std::string drawing = svg(chart);
  const auto first = drawing.find("<path d=\"M") + 10;
  EXPECT_LT(drawing.find('M', first), drawing.find('"', first));
  EXPECT_THAT(drawing, Not(HasSubstr("nan")));
}

TEST(Svg, NothingToDrawIsNothing) {
  EXPECT_EQ(svg(Chart{}), "");
  Chart chart = make_chart();
  chart.series[0].y = {1};
  EXPECT_EQ(svg(chart), "");
}

TEST(Svg, ConstantLinesAreDrawn) {
  Chart chart = make_chart();
  for (const double level : {0.0, -2.0, 1e6}) {
    chart.series[0].y = {level, level, level, level};
    const std::string drawing = svg(chart);
    const auto path = drawing.find("<path d=\"M");
    ASSERT_NE(path, std::string::npos) << level;
    // From "M" on, four points "x y" of one height.
    const std::vector<double> heights = heights_of(drawing.substr(path + 9));
    ASSERT_EQ(heights.size(), 4u) << level;
    for (const double height : heights) EXPECT_EQ(height, heights.front()) << level;
    EXPECT_THAT(drawing, Not(HasSubstr("nan"))) << level;
    EXPECT_THAT(drawing, Not(HasSubstr("inf"))) << level;
  }
}

/// Where a label's words begin or end.
std::array<double, 2> place_of(const std::string& drawing, const std::string& words) {
  const auto end = drawing.find(">" + words + "</text>");
  const auto start = drawing.rfind("<text x=\"", end);
  EXPECT_NE(end, std::string::npos) << words;
  const auto y = drawing.find("y=\"", start + 9);
  return {std::stod(drawing.substr(start + 9)), std::stod(drawing.substr(y + 3))};
}

TEST(SweepPlot, HasNoLegendForOneCurveAndNoTrendInNoise) {
  const angio::test::TemporaryFolder folder;
  const auto drawn = [&](const std::vector<double>& percent, const std::string& label) {
    write_sweep_plot(folder / "a.svg", "pressure [atm]",
                     {{"recoil [%]", {{label, {6.0, 8.0, 10.0}, percent}}}});
    return read_text(folder / "a.svg");
  };
  const auto keys = [](const std::string& svg) {  // short lines at the top are the legend's
    std::size_t count = 0;
    for (std::size_t i = svg.find("x1=\"62.0\" y1=\"18.0\" x2=\"84.0\""); i != std::string::npos;
         i = svg.find("x1=\"62.0\" y1=\"18.0\" x2=\"84.0\"", i + 1))
      ++count;
    return count;
  };
  EXPECT_EQ(keys(drawn({20.0, 25.0, 30.0}, "")), 0u);
  EXPECT_EQ(keys(drawn({20.0, 25.0, 30.0}, "3 mm")), 1u);
  // The heights of the marks on paper: noise of 0.2 points is a tenth of an axis of two points.
  const auto height = [](const std::string& svg) {
    double low = 1e9, high = -1e9;
    for (std::size_t i = svg.find(" cy=\""); i != std::string::npos;
         i = svg.find(" cy=\"", i + 1)) {
      const double y = std::stod(svg.substr(i + 5));
      low = std::min(low, y);
      high = std::max(high, y);
    }
    return high - low;
  };
  const double noise = height(drawn({24.9, 25.0, 25.1}, "")),
               trend = height(drawn({20.0, 25.0, 30.0}, ""));
  EXPECT_GT(noise, 0.0);
  EXPECT_LT(noise, 0.12 * trend);
}

TEST(Svg, NamesThatDoNotFitBesideEachOtherGoToTheNextRow) {
  Chart chart = make_chart();
  chart.width = 420;
  chart.series[0].label = "what is measured before";
  chart.series.push_back({"what is measured after it", {0, 1}, {0, 1}, 2, false});
  chart.series.push_back({"and at peak", {0, 1}, {0, 1}, 3, false});
  const std::string drawing = svg(chart);
  const auto first = place_of(drawing, chart.series[0].label),
             second = place_of(drawing, chart.series[1].label),
             third = place_of(drawing, chart.series[2].label);
  EXPECT_EQ(first[0], second[0]);
  EXPECT_GE(second[1], first[1] + 16.0);
  EXPECT_EQ(third[1], second[1]);
  EXPECT_GT(third[0], second[0] + 100.0);
}

TEST(Svg, LabelsOfMarksAtOnePlaceLieApart) {
  Chart chart = make_chart();
  for (const char* name : {"before", "at peak", "after"}) chart.marks.push_back({1, 1, name, 1});
  const std::string drawing = svg(chart);
  std::vector<std::array<double, 2>> places;  // above each other, or on both sides of the mark
  for (const ChartMark& mark : chart.marks) places.push_back(place_of(drawing, mark.label));
  for (std::size_t a = 0; a < places.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_TRUE(std::abs(places[a][1] - places[b][1]) >= 16.0 ||
                  std::abs(places[a][0] - places[b][0]) >= 18.0)
          << chart.marks[a].label << ", " << chart.marks[b].label;
}

TEST(ChartLabels, KeepOffTheCurvesAndOffEachOther) {
  ChartLabels labels({0.0, 200.0, 0.0, 100.0});
  labels.keep_off({{0.0, 40.0}, {200.0, 40.0}});
  const std::vector<LabelPlace> wanted = {{10.0, 44.0}, {10.0, 70.0}, {10.0, 90.0}};
  EXPECT_EQ(labels.place(wanted, 50.0).y, 70.0);  // not across the line
  EXPECT_EQ(labels.place(wanted, 50.0).y, 90.0);  // not on the first
  EXPECT_EQ(labels.place(wanted, 50.0).y, 44.0);  // rather on a line than on a label
  EXPECT_EQ(labels.place({{190.0, 20.0}, {190.0, 20.0, LabelPlace::Anchor::end}}, 50.0).anchor,
            LabelPlace::Anchor::end);  // inside
}

TEST(Svg, AMarkOnACurveIsNamedBesideIt) {
  Chart chart = make_chart();
  chart.series[0] = {"rises to the mark", {0, 1, 2}, {0, 1, 1}, 1, false};
  chart.marks = {{2, 1, "the highest of them", 1}};
  const std::string drawing = svg(chart);
  const auto at = place_of(drawing, "the highest of them");
  const double line = heights_of(drawing.substr(drawing.find("<path d=\"M") + 9)).back();
  EXPECT_GT(std::abs(at[1] - 4.0 - line), 8.0);
}

TEST(Svg, ForAPageIsDrawnForWideAndForNarrowOnes) {
  const std::string drawing = svg_for_page(make_chart());
  EXPECT_THAT(drawing, HasSubstr("<div class=\"on-wide\"><svg"));
  EXPECT_THAT(drawing,
              HasSubstr("<div class=\"on-narrow\"><svg class=\"chart\" viewBox=\"0 0 420"));
  EXPECT_EQ(svg_for_page(Chart{}), "");
}

TEST(Column, IsNumbersAndNotANumberWhereThereIsNone) {
  const TimeSeries series{{"time_s", "phase"}, {{"0.5", "inflate"}, {"", "hold"}, {}}};
  const auto time = column(series, "time_s");
  ASSERT_EQ(time.size(), 3u);
  EXPECT_EQ(time[0], 0.5);
  EXPECT_TRUE(std::isnan(time[1]));
  EXPECT_TRUE(std::isnan(time[2]));
  EXPECT_TRUE(column(series, "none").empty());
}

TEST(Base64, GivesTheVectorsOfRfc4648) {
  EXPECT_EQ(formats::base64(""), "");
  EXPECT_EQ(formats::base64("f"), "Zg==");
  EXPECT_EQ(formats::base64("fo"), "Zm8=");
  EXPECT_EQ(formats::base64("foo"), "Zm9v");
  EXPECT_EQ(formats::base64("foob"), "Zm9vYg==");
  EXPECT_EQ(formats::base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(formats::base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(formats::base64("\xff\xfe\xfd"), "//79");
}

TEST(EscapeHtml, LeavesNothingThatEndsTextOrAttribute) {
  EXPECT_EQ(formats::escape_html("<a href=\"x\">'&'</a>"),
            "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(formats::escape_html(std::string("a\0b\x1f", 4)), "a b ");
  EXPECT_EQ(formats::escape_html("mm² → ü"), "mm² → ü");
}

TEST(FixedText, IsPlainAndKnowsNoMinusZero) {
  EXPECT_EQ(formats::fixed_text(1.005, 1), "1.0");
  EXPECT_EQ(formats::fixed_text(-0.04, 1), "0.0");
  EXPECT_EQ(formats::fixed_text(-0.06, 1), "-0.1");
  EXPECT_EQ(formats::fixed_text(1e300 * 1e300, 1), "–");
  EXPECT_EQ(formats::number_text(0.025), "0.025");
}

}  // namespace
}  // namespace angio::viewer::detail
