#include "viewer/detail/chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "formats/html.hpp"
#include "formats/text.hpp"
#include "viewer/detail/chart_labels.hpp"

namespace angio::viewer::detail {
namespace {

constexpr double kLeft = 62, kRight = 16, kBottom = 46;              // [px]
constexpr double kLegendRow = 18, kLegendKey = 28, kLegendGap = 18;  // [px]
constexpr double kUsualLetter = 7.2;                                 // a usual letter's width [px]
constexpr double kBold = 1.14;                                       // of a bold one, likewise
constexpr int kNarrow = 420;                                         // a phone's column [px]
constexpr std::size_t kMaxHoverPoints = 80;
constexpr std::size_t kMaxLinePoints = 1200;

/// Where data lie on the paper.
struct Frame {
  double x_low = 0, x_high = 1, y_low = 0, y_high = 1;
  int decimals_x = 0, decimals_y = 0;
  bool has_own_ticks = false;  ///< along x: values as they were given
  double width = 0, height = 0, top = 0;

  [[nodiscard]] double px(double x) const {
    return kLeft + (x - x_low) / (x_high - x_low) * (width - kLeft - kRight);
  }
  [[nodiscard]] double py(double y) const {
    return height - kBottom - (y - y_low) / (y_high - y_low) * (height - top - kBottom);
  }
};

std::string at(double value) { return formats::fixed_text(value, 1); }

/// The range of the finite values.
struct FiniteRange {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] bool is_empty() const { return low > high; }
};

bool can_be_drawn(const Chart& chart) {
  return std::any_of(chart.series.begin(), chart.series.end(), [](const ChartSeries& s) {
    int finite = 0;
    for (std::size_t i = 0; i < s.x.size() && i < s.y.size(); ++i)
      finite += std::isfinite(s.x[i]) && std::isfinite(s.y[i]) ? 1 : 0;
    return finite >= 2;
  });
}

double text_width(const std::string& words) { return kUsualLetter * double(words.size()); }

/// A row of the legend's keys: which line, and its name.
struct LegendEntry {
  std::string css, name;
  double x = 0, y = 0;
};

/// The legend's entries, in rows from left to right.
std::vector<LegendEntry> lay_out_legend(const Chart& chart) {
  std::vector<LegendEntry> entries;
  for (const ChartSeries& series : chart.series)
    if (series.is_in_legend)
      entries.push_back({"line s" + std::to_string(series.color) + (series.dashed ? " dashed" : ""),
                         series.label});
  if (!chart.dashed_means.empty()) entries.push_back({"line axis dashed", chart.dashed_means});
  double x = kLeft, y = kLegendRow;
  for (LegendEntry& entry : entries) {
    const double width = kLegendKey + text_width(entry.name);
    if (x > kLeft && x + width > chart.width) {
      x = kLeft;
      y += kLegendRow;
    }
    entry.x = x;
    entry.y = y;
    x += width + kLegendGap;
  }
  return entries;
}

/// The ticks that are asked for, as far as their numbers have room; the last one has it always.
std::vector<double> ticks_with_room(const std::vector<double>& wanted, const Frame& frame) {
  std::vector<double> ticks;
  const auto half = [](double value) { return 0.5 * text_width(formats::number_text(value)) + 4; };
  const auto are_apart = [&](double a, double b) {
    return frame.px(b) - frame.px(a) >= half(a) + half(b);
  };
  for (const double value : wanted)
    if (ticks.empty() || are_apart(ticks.back(), value)) ticks.push_back(value);
  if (ticks.empty() || ticks.back() == wanted.back()) return ticks;
  while (ticks.size() > 1 && !are_apart(ticks.back(), wanted.back())) ticks.pop_back();
  ticks.push_back(wanted.back());
  return ticks;
}

Frame make_frame(const Chart& chart, std::vector<double>& x_ticks, std::vector<double>& y_ticks) {
  FiniteRange x, y;
  for (const ChartSeries& s : chart.series)
    for (std::size_t i = 0; i < s.x.size() && i < s.y.size(); ++i) {
      x.add(s.x[i]);
      y.add(s.y[i]);
    }
  for (const ChartLevel& level : chart.levels) y.add(level.y);
  if (chart.y_from_zero) y.add(0.0);
  if (x.high - x.low <= 0.0) x.high = x.low + 1.0;
  if (y.high - y.low <= 0.0) y.high = y.low + 1.0;
  if (const double lack = chart.y_least_span - (y.high - y.low); lack > 0.0) {
    y.low -= 0.5 * lack;
    y.high += 0.5 * lack;
  }
  x_ticks = round_ticks(x.low, x.high, std::clamp(chart.width / 90, 3, 8));
  constexpr double kHeadroom = 1.08;  // for the names of the bands
  const bool is_named = std::any_of(chart.bands.begin(), chart.bands.end(),
                                    [](const ChartBand& band) { return !band.label.empty(); });
  const double headroom = is_named && y.high > 0.0 ? kHeadroom : 1.0;
  y_ticks = round_ticks(y.low, y.high * headroom, 5);
  Frame frame;
  frame.x_low = x.low;
  frame.x_high = x.high;
  frame.y_low = y_ticks.front();
  frame.y_high = y_ticks.back();
  frame.decimals_x = tick_decimals(x_ticks[1] - x_ticks[0]);
  frame.decimals_y = tick_decimals(y_ticks[1] - y_ticks[0]);
  frame.width = chart.width;
  frame.height = chart.height;
  const std::vector<LegendEntry> legend = lay_out_legend(chart);
  frame.top = 16.0 + (legend.empty() ? 0.0 : legend.back().y);
  if (!chart.x_ticks.empty()) {
    constexpr double kMargin = 0.03;  // so that no mark lies on the axis
    frame.x_low = x.low - kMargin * (x.high - x.low);
    frame.x_high = x.high + kMargin * (x.high - x.low);
    frame.has_own_ticks = true;
    x_ticks = ticks_with_room(chart.x_ticks, frame);
  }
  return frame;
}

std::string text(double x, double y, const char* css, const std::string& words) {
  return "<text x=\"" + at(x) + "\" y=\"" + at(y) + "\" class=\"" + css + "\">" +
         formats::escape_html(words) + "</text>";
}

std::string line(double x1, double y1, double x2, double y2, const char* css) {
  return "<line x1=\"" + at(x1) + "\" y1=\"" + at(y1) + "\" x2=\"" + at(x2) + "\" y2=\"" + at(y2) +
         "\" class=\"" + css + "\"/>";
}

std::string draw_axes(const Chart& chart, const Frame& frame, const std::vector<double>& x_ticks,
                      const std::vector<double>& y_ticks) {
  std::string out;
  const double bottom = frame.height - kBottom, right = frame.width - kRight;
  for (const double tick : y_ticks) {
    const double y = frame.py(tick);
    out += line(kLeft, y, right, y, "grid");
    out += text(kLeft - 7, y + 4, "tick end", formats::fixed_text(tick, frame.decimals_y));
  }
  for (const double tick : x_ticks) {
    if (tick < frame.x_low - 1e-9 || tick > frame.x_high + 1e-9) continue;
    const double x = frame.px(tick);
    out += line(x, bottom, x, bottom + 4, "axis");
    out += text(x, bottom + 17, "tick mid",
                frame.has_own_ticks ? formats::number_text(tick)
                                    : formats::fixed_text(tick, frame.decimals_x));
  }
  out += line(kLeft, bottom, right, bottom, "axis");
  out += text(0.5 * (kLeft + right), frame.height - 10, "label mid", chart.x_label);
  const std::string middle = at(0.5 * (frame.top + bottom));
  out += "<text transform=\"translate(16 " + middle + ") rotate(-90)\" class=\"label mid\">" +
         formats::escape_html(chart.y_label) + "</text>";
  return out;
}

std::string draw_bands(const Chart& chart, const Frame& frame) {
  std::string out;
  bool shaded = false;
  for (const ChartBand& band : chart.bands) {
    const double x1 = frame.px(std::clamp(band.first, frame.x_low, frame.x_high));
    const double x2 = frame.px(std::clamp(band.last, frame.x_low, frame.x_high));
    if (shaded)
      out += "<rect x=\"" + at(x1) + "\" y=\"" + at(frame.top) + "\" width=\"" + at(x2 - x1) +
             "\" height=\"" + at(frame.height - frame.top - kBottom) + "\" class=\"band\"/>";
    if (!band.label.empty() && x2 - x1 > text_width(band.label))
      out += text(0.5 * (x1 + x2), frame.top + 12, "tick mid", band.label);
    shaded = !shaded;
  }
  return out;
}

/// An invisible dot that tells its value under the mouse.
std::string hover_point(const ChartSeries& series, std::size_t i, const Chart& chart,
                        const Frame& frame) {
  const std::string words =
      series.label + ": " + formats::fixed_text(series.y[i], frame.decimals_y + 2) + " (" +
      chart.x_label + " " + formats::fixed_text(series.x[i], frame.decimals_x + 1) + ")";
  return "<circle cx=\"" + at(frame.px(series.x[i])) + "\" cy=\"" + at(frame.py(series.y[i])) +
         "\" r=\"6\" class=\"hover s" + std::to_string(series.color) + "\"><title>" +
         formats::escape_html(words) + "</title></circle>";
}

/// Every stride-th point; a long series would only make the page heavy.
std::string draw_series(const ChartSeries& series, const Frame& frame, const Chart& chart) {
  const std::size_t count = std::min(series.x.size(), series.y.size());
  const std::size_t line_stride = 1 + count / kMaxLinePoints;
  const std::size_t hover_stride = 1 + count / kMaxHoverPoints;
  const std::string css = "s" + std::to_string(series.color);
  std::string path, hovers;
  bool pen_down = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) {
      pen_down = false;
      continue;
    }
    const std::string x = at(frame.px(series.x[i])), y = at(frame.py(series.y[i]));
    if (i % line_stride == 0 || i + 1 == count) {
      path.append(pen_down ? "L" : "M").append(x).append(" ").append(y);
      pen_down = true;
    }
    if (chart.tells_values && (i % hover_stride == 0 || i + 1 == count))
      hovers.append(hover_point(series, i, chart, frame));
  }
  return "<path d=\"" + path + "\" class=\"line " + css + (series.dashed ? " dashed" : "") +
         "\"/>" + hovers;
}

std::string write_label(const LabelPlace& place, const std::string& css, const std::string& words) {
  using Anchor = LabelPlace::Anchor;
  const char* anchor = place.anchor == Anchor::end      ? " end"
                       : place.anchor == Anchor::middle ? " mid"
                                                        : "";
  return text(place.x, place.y, (css + anchor).c_str(), words);
}

/// What no label should be written across.
ChartLabels make_labels(const Chart& chart, const Frame& frame) {
  ChartLabels labels({kLeft, frame.width, frame.top - 6.0, frame.height - kBottom});
  const auto keep_off = [&](const std::vector<double>& x, const std::vector<double>& y) {
    std::vector<std::array<double, 2>> points;
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
      points.push_back({frame.px(x[i]), frame.py(y[i])});
    labels.keep_off(points);
  };
  for (const ChartSeries& series : chart.series) keep_off(series.x, series.y);
  for (const ChartLevel& level : chart.levels)
    keep_off({frame.x_low, frame.x_high}, {level.y, level.y});
  for (const ChartMark& mark : chart.marks) keep_off({mark.x}, {mark.y});
  return labels;
}

/// Above or below the level, at its right end first, then further and further to the left.
std::string draw_levels(const Chart& chart, const Frame& frame, ChartLabels& labels) {
  constexpr double kAbove = -5.0, kBelow = 14.0, kStep = 30.0;  // [px]
  std::string out;
  const double right = frame.width - kRight;
  for (const ChartLevel& level : chart.levels) {
    const double y = frame.py(level.y), width = text_width(level.label);
    out += line(kLeft, y, right, y, "level");
    std::vector<LabelPlace> places;
    for (double end = right - 4; end - width >= kLeft + 6; end -= kStep)
      for (const double down : {kAbove, kBelow})
        places.push_back({end, y + down, LabelPlace::Anchor::end});
    if (places.empty()) places.push_back({right - 4, y + kAbove, LabelPlace::Anchor::end});
    out += write_label(labels.place(places, width), "tick halo", level.label);
  }
  return out;
}

/// Where a mark's name may stand: near, and nearer to it than to any other mark.
std::vector<LabelPlace> places_of(const ChartMark& mark, const Chart& chart, const Frame& frame) {
  using Anchor = LabelPlace::Anchor;
  constexpr double kFar = 0.5, kNearerToAnother = 60.0;  // costs: of each pixel; once
  const double x = frame.px(mark.x), y = frame.py(mark.y);
  std::vector<LabelPlace> places;
  for (const double down : {14.0, -8.0, 4.0, 24.0, -18.0, 34.0, -28.0, 46.0, -40.0}) {
    const double cost = kFar * std::abs(down - 4.0);
    places.push_back({x + 9, y + down, Anchor::start, cost});
    places.push_back({x - 9, y + down, Anchor::end, cost});
    if (std::abs(down - 4.0) > 15.0) places.push_back({x, y + down, Anchor::middle, cost});
  }
  for (LabelPlace& place : places) {
    const LabelBox box = box_of(place, kBold * text_width(mark.label));
    const double own = distance_to(box, x, y);
    const bool misleads =
        std::any_of(chart.marks.begin(), chart.marks.end(), [&](const ChartMark& other) {
          return &other != &mark && distance_to(box, frame.px(other.x), frame.py(other.y)) <= own;
        });
    if (misleads) place.cost += kNearerToAnother;
  }
  return places;
}

std::string draw_marks(const Chart& chart, const Frame& frame, ChartLabels& labels) {
  std::string out;
  for (const ChartMark& mark : chart.marks) {
    if (!std::isfinite(mark.x) || !std::isfinite(mark.y)) continue;
    const std::string color = std::to_string(mark.color);
    out += "<circle cx=\"" + at(frame.px(mark.x)) + "\" cy=\"" + at(frame.py(mark.y)) +
           "\" r=\"4.5\" class=\"mark s" + color + "\"><title>" + formats::escape_html(mark.label) +
           "</title></circle>";
    if (mark.label.empty()) continue;
    const LabelPlace place =
        labels.place(places_of(mark, chart, frame), kBold * text_width(mark.label));
    out += write_label(place, "note n" + color, mark.label);
  }
  return out;
}

std::string draw_legend(const Chart& chart) {
  std::string out;
  for (const LegendEntry& entry : lay_out_legend(chart)) {
    out += line(entry.x, entry.y, entry.x + 22, entry.y, entry.css.c_str());
    out += text(entry.x + kLegendKey, entry.y + 4, "tick", entry.name);
  }
  return out;
}

// Plain colours: programs that are no browsers know no style variables.
constexpr const char* kFileStyle = R"css(
.grid{stroke:#e6e8ec}.axis{stroke:#5b6472}.band{fill:#f1f3f6}
.level{stroke:#5b6472;stroke-dasharray:7 5}
text{fill:#1d2128;font:12px system-ui,Arial,sans-serif}.tick{fill:#5b6472}
.title{font-weight:600;font-size:15px}.note{font-weight:600}
.note,.halo{paint-order:stroke;stroke:#fff;stroke-width:3px;stroke-linejoin:round}
.mid{text-anchor:middle}.end{text-anchor:end}
.line{fill:none;stroke-width:2;stroke-linejoin:round}
.dashed{stroke-dasharray:3 4;stroke-width:1.4}
.s1{stroke:#1f6fc4}.s2{stroke:#d9690f}.s3{stroke:#23864a}.s4{stroke:#8a4fb8}
.n1{fill:#1a5ca3}.n2{fill:#a84f00}.n3{fill:#1b6b3a}.n4{fill:#6f3f95}
.mark{fill:#fff;stroke-width:2}.hover{fill:transparent;stroke:none}
)css";

}  // namespace

std::vector<double> round_ticks(double low, double high, int wanted_count) {
  const double rough = (high - low) / std::max(1, wanted_count);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double digit : {5.0, 2.0, 1.0})
    if (digit * power >= rough * (1.0 - 1e-9)) step = digit * power;
  std::vector<double> ticks;
  const auto first = std::llround(std::floor(low / step + 1e-9));
  const auto last = std::llround(std::ceil(high / step - 1e-9));
  for (auto i = first; i <= std::max(last, first + 1); ++i) ticks.push_back(double(i) * step);
  return ticks;
}

std::vector<double> bar_ticks(double low, double high) {
  constexpr double kRoom = 0.12;  // of the bar, for a number
  std::vector<double> ticks{low};
  for (const double tick : round_ticks(low, high, 5))
    if (std::min(tick - low, high - tick) > kRoom * (high - low)) ticks.push_back(tick);
  ticks.push_back(high);
  return ticks;
}

int tick_decimals(double step) {
  return std::clamp(int(std::ceil(-std::log10(step) - 1e-9)), 0, 12);
}

std::string svg(const Chart& chart) {
  if (!can_be_drawn(chart)) return {};
  std::vector<double> x_ticks, y_ticks;
  const Frame frame = make_frame(chart, x_ticks, y_ticks);
  std::string out = "<svg class=\"chart\" viewBox=\"0 0 " + std::to_string(chart.width) + " " +
                    std::to_string(chart.height) + "\" role=\"img\" aria-label=\"" +
                    formats::escape_html(chart.title) + "\">";
  out += draw_bands(chart, frame);
  out += draw_axes(chart, frame, x_ticks, y_ticks);
  ChartLabels labels = make_labels(chart, frame);
  out += draw_levels(chart, frame, labels);
  for (const ChartSeries& series : chart.series) out += draw_series(series, frame, chart);
  out += draw_marks(chart, frame, labels);
  out += draw_legend(chart);
  return out + "</svg>";
}

std::string svg_for_page(const Chart& chart) {
  Chart narrow = chart;
  narrow.width = kNarrow;
  narrow.height = std::max(chart.height, 330);
  narrow.tells_values = false;
  const std::string drawing = svg(narrow);
  if (drawing.empty()) return {};
  return "<div class=\"on-wide\">" + svg(chart) + "</div><div class=\"on-narrow\">" + drawing +
         "</div>";
}

std::string svg_file(const std::vector<Chart>& charts, const std::vector<std::string>& notes) {
  constexpr int kTitleHeight = 34, kNoteHeight = 20;
  int width = 0, height = 0;
  std::string parts;
  for (const Chart& chart : charts) {
    const std::string body = svg(chart);
    if (body.empty()) continue;
    parts += "<text x=\"20\" y=\"" + std::to_string(height + 24) + "\" class=\"title\">" +
             formats::escape_html(chart.title) + "</text><svg y=\"" +
             std::to_string(height + kTitleHeight) + "\" width=\"" + std::to_string(chart.width) +
             "\" height=\"" + std::to_string(chart.height) + "\" " +
             body.substr(std::string("<svg ").size());
    height += kTitleHeight + chart.height;
    width = std::max(width, chart.width);
  }
  if (parts.empty()) return {};
  for (const std::string& note : notes) {
    parts += text(20, height + kNoteHeight, "tick", note);
    height += kNoteHeight;
  }
  if (!notes.empty()) height += kNoteHeight;
  const std::string size = std::to_string(width) + "\" height=\"" + std::to_string(height);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + size + "\" viewBox=\"0 0 " +
         std::to_string(width) + " " + std::to_string(height) + "\"><style>" + kFileStyle +
         "</style><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>" + parts + "</svg>\n";
}

}  // namespace angio::viewer::detail
