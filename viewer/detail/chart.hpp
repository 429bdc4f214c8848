#pragma once

#include <string>
#include <vector>

namespace angio::viewer::detail {

/// One line of a chart. Values that are not finite break it.
struct ChartSeries {
  std::string label;
  std::vector<double> x;
  std::vector<double> y;  ///< as many as x
  int color = 1;          ///< 1 to 4, told apart in light, dark and print by the page's style
  bool dashed = false;
  bool is_in_legend = true;
};

struct ChartMark {
  double x = 0.0;
  double y = 0.0;
  std::string label;
  int color = 1;
};

/// A level across the whole chart.
struct ChartLevel {
  double y = 0.0;
  std::string label;
};

/// A named stretch of the x axis.
struct ChartBand {
  double first = 0.0;
  double last = 0.0;
  std::string label;
};

struct Chart {
  std::string title;
  std::string x_label;  ///< with its unit
  std::string y_label;  ///< with its unit
  std::vector<ChartSeries> series;
  std::vector<ChartMark> marks;
  std::vector<ChartLevel> levels;
  std::vector<ChartBand> bands;
  std::vector<double> x_ticks = {};  ///< ascending; empty: round numbers
  std::string dashed_means = {};     ///< of the series that are not in the legend; empty: nothing
  bool y_from_zero = true;
  double y_least_span = 0.0;  ///< of the y axis, so that noise looks like none
  int width = 760;            ///< [px]
  int height = 280;           ///< [px]
  bool tells_values = true;   ///< under the mouse
};

/// The chart as an inline SVG element with axes, legend and hover titles; it scales with the page
/// and takes its colours from the page's style. Labels do not lie on each other where there is
/// another place beside what they name. Empty if no series has two finite values.
std::string svg(const Chart& chart);

/// The chart twice, for wide pages and for phones, where it is drawn anew for a narrow column: its
/// letters keep their size. The page's style shows one of them.
std::string svg_for_page(const Chart& chart);

/// Charts below each other, each with its title, as a file of its own, for programs that are no
/// browsers; those that are empty are left out. Empty if all are.
///
/// @param notes  lines below the charts
std::string svg_file(const std::vector<Chart>& charts, const std::vector<std::string>& notes = {});

/// Round steps (1, 2 or 5 times a power of ten) from at or below `low` to at or above `high`.
std::vector<double> round_ticks(double low, double high, int wanted_count);
/// The values that a colour bar names: both of its ends, and round ones between that have room.
std::vector<double> bar_ticks(double low, double high);

/// Decimals that ticks with this step need.
int tick_decimals(double step);

}  // namespace angio::viewer::detail
