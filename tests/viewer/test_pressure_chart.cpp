#include <gtest/gtest.h>

#include "viewer/detail/report_charts.hpp"

namespace angio::viewer::detail {
namespace {

/// Up to 8 atm, held there, and down again; the vessel keeps the balloon wider on its way down.
ReportContent make_inflation() {
  ReportContent content;
  content.time_series.columns = {"pressure_atm", "balloon_diameter_mm"};
  content.time_series.rows = {{"0", "1.0"}, {"4", "2.0"}, {"8", "2.9"},
                              {"8", "3.0"}, {"4", "2.8"}, {"0", "1.5"}};
  content.balloon_chart = {{4.0, 14.0}, {2.9, 3.2}};
  return content;
}

const ChartSeries& series(const Chart& chart, const std::string& label) {
  for (const ChartSeries& one : chart.series)
    if (one.label.starts_with(label)) return one;
  ADD_FAILURE() << label;
  return chart.series.front();
}

TEST(PressureDiameterChart, PartsTheWayUpFromTheWayDownWhereThePeakIsNoLongerHeld) {
  const Chart chart = pressure_diameter_chart(make_inflation(), Metrics(""));
  EXPECT_EQ(series(chart, "in the vessel").y, (std::vector<double>{1.0, 2.0, 2.9, 3.0}));
  EXPECT_EQ(series(chart, "deflating").y, (std::vector<double>{3.0, 2.8, 1.5}));
  ASSERT_EQ(chart.marks.size(), 1u);
  EXPECT_EQ(chart.marks[0].label, "peak 8.0 atm, 3.00 mm");
  EXPECT_EQ(chart.series.size(), 3u);  // the balloon's chart, no rated pressure
}

TEST(PressureDiameterChart, ShowsWhatTheBalloonIsRatedForEvenFarAboveThePeak) {
  const Chart chart =
      pressure_diameter_chart(make_inflation(), Metrics(R"({"balloon":{"rated_burst_atm":20}})"));
  const ChartSeries& rated = series(chart, "rated burst pressure, 20.0 atm");
  EXPECT_EQ(rated.x, (std::vector<double>{20.0, 20.0}));
  EXPECT_EQ(rated.y, (std::vector<double>{0.0, 3.2}));
}

TEST(PressureDiameterChart, OfNoInflationIsEmpty) {
  EXPECT_TRUE(pressure_diameter_chart({}, Metrics("")).series.empty());
}

}  // namespace
}  // namespace angio::viewer::detail
