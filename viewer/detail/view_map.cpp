#include "viewer/detail/view_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/text.hpp"

namespace angio::viewer::detail {
namespace {

using angiogram::SeenSegment;
using angiogram::ViewMap;

constexpr double kLeft = 58, kRight = 30, kTop = 22, kBottom = 54;  // [px]
constexpr double kWide = 760, kNarrow = 420;                        // [px]
constexpr double kSeam = 0.4;                                       // what neighbours share [px]
constexpr double kTick = 30.0, kFineTick = 10.0;                    // [degrees]
constexpr double kOverlapped = 2.0;  // [%]: from here on a view is hatched

/// A band begins at its number [%] and ends at the next one's.
struct Band {
  double from;
  const char* color;
};
constexpr std::array<Band, 7> kBands{{{0, "#f3f8fc"},
                                      {2, "#d3e4f3"},
                                      {5, "#a9cde8"},
                                      {10, "#74b0da"},
                                      {20, "#468fc6"},
                                      {30, "#2267a9"},
                                      {50, "#0b3f78"}}};

std::size_t band_of(double percent) {
  std::size_t band = 0;
  while (band + 1 < kBands.size() && percent >= kBands[band + 1].from) ++band;
  return band;
}

std::string pixels(double value) { return formats::fixed_text(value, 1); }

/// Where angles lie on the paper.
struct Paper {
  double width, primary_low, primary_high, secondary_low, secondary_high, scale;

  Paper(const ViewMap& map, double paper_width)
      : width(paper_width),
        primary_low(map.primary_degrees.front()),
        primary_high(map.primary_degrees.back()),
        secondary_low(map.secondary_degrees.front()),
        secondary_high(map.secondary_degrees.back()),
        scale((width - kLeft - kRight) / std::max(primary_high - primary_low, 1.0)) {}
  [[nodiscard]] double x(double primary) const { return kLeft + (primary - primary_low) * scale; }
  [[nodiscard]] double y(double secondary) const {
    return kTop + (secondary_high - secondary) * scale;
  }
  [[nodiscard]] double height() const { return y(secondary_low) + kBottom; }
};

/// Half way to the neighbours; at an edge the edge.
std::array<double, 2> cell(const std::vector<double>& angles, std::size_t i) {
  return {i == 0 ? angles[i] : 0.5 * (angles[i - 1] + angles[i]),
          i + 1 == angles.size() ? angles[i] : 0.5 * (angles[i] + angles[i + 1])};
}

/// Runs of views of a row that are alike, as rectangles.
std::string draw_bands(const ViewMap& map, const Paper& paper) {
  std::string out;
  const std::size_t columns = map.primary_degrees.size();
  for (std::size_t row = 0; row < map.secondary_degrees.size(); ++row) {
    const auto [low, high] = cell(map.secondary_degrees, row);
    for (std::size_t begin = 0, end = 0; begin < columns; begin = end) {
      const auto band_at = [&](std::size_t column) {
        return band_of(map.views[row * columns + column].foreshortening_percent);
      };
      const std::size_t band = band_at(begin);
      while (end < columns && band_at(end) == band) ++end;
      const double x0 = paper.x(cell(map.primary_degrees, begin)[0]);
      const double x1 = paper.x(cell(map.primary_degrees, end - 1)[1]);
      out += "<rect x=\"" + pixels(x0) + "\" y=\"" + pixels(paper.y(high)) + "\" width=\"" +
             pixels(x1 - x0 + kSeam) + "\" height=\"" +
             pixels(paper.y(low) - paper.y(high) + kSeam) + "\" fill=\"" + kBands[band].color +
             "\"/>";
    }
  }
  return out;
}

/// A stroke across each view that is overlapped.
std::string draw_hatching(const ViewMap& map, const Paper& paper) {
  std::string strokes;
  const std::size_t columns = map.primary_degrees.size();
  for (std::size_t v = 0; v < map.views.size(); ++v) {
    if (map.views[v].overlap_percent <= kOverlapped) continue;
    const auto [left, right] = cell(map.primary_degrees, v % columns);
    const auto [low, high] = cell(map.secondary_degrees, v / columns);
    strokes += "M" + pixels(paper.x(left)) + " " + pixels(paper.y(low)) + "L" +
               pixels(paper.x(right)) + " " + pixels(paper.y(high));
  }
  return strokes.empty() ? strokes : "<path class=\"hatching\" d=\"" + strokes + "\"/>";
}

/// In whole degrees.
std::string degrees(double angle) { return formats::fixed_text(std::abs(angle), 0); }

std::string text(double x, double y, const char* css, const std::string& words) {
  return "<text x=\"" + pixels(x) + "\" y=\"" + pixels(y) + "\" class=\"" + css + "\">" + words +
         "</text>";
}

std::string draw_axes(const Paper& paper) {
  std::string out;
  const double bottom = paper.y(paper.secondary_low);
  // A name takes about 50 pixels.
  const double step = kFineTick * paper.scale > 50.0 ? kFineTick
                      : kTick * paper.scale > 50.0   ? kTick
                                                     : 2 * kTick;
  for (double p = std::ceil(paper.primary_low / step) * step; p <= paper.primary_high; p += step)
    out += text(paper.x(p), bottom + 22, "tick mid",
                p == 0.0 ? "AP" : (p < 0 ? "RAO " : "LAO ") + degrees(p));
  const double rise = kFineTick * paper.scale > 30.0 ? kFineTick : 2 * kFineTick;
  for (double s = std::ceil(paper.secondary_low / rise) * rise; s <= paper.secondary_high;
       s += rise)
    out += text(kLeft - 6, paper.y(s) + 4, "tick end",
                s == 0.0 ? "0" : (s < 0 ? "CAU " : "CRA ") + degrees(s));
  return out + text(kLeft + 0.5 * (paper.width - kLeft - kRight), bottom + 44, "tick mid",
                    "C-arm, to the right (RAO) and left (LAO) [degrees]");
}

enum class NameSide { above, below };

std::string draw_mark(const Paper& paper, const SeenSegment& view, const std::string& name,
                      NameSide side) {
  const double x = paper.x(view.angles.primary_degrees), y = paper.y(view.angles.secondary_degrees);
  const bool is_right = x > 0.6 * paper.width;
  const bool is_below = side == NameSide::below && y + 24 < paper.y(paper.secondary_low);
  const double high = is_below ? y + 20 : y - 10;
  return "<circle cx=\"" + pixels(x) + "\" cy=\"" + pixels(y) +
         "\" r=\"6\" fill=\"#fff\" stroke=\"#111\" stroke-width=\"2.5\"/>" +
         text(x + (is_right ? -9 : 9), high, is_right ? "on-map end" : "on-map",
              name + ": " + angiogram::c_arm_label(view.angles));
}

}  // namespace

std::string view_map_svg(const angiogram::WorkingView& view, MapWidth width) {
  const ViewMap& map = view.map;
  if (map.views.empty()) return {};
  const Paper paper(map, width == MapWidth::wide ? kWide : kNarrow);
  std::string out = "<svg class=\"chart\" viewBox=\"0 0 " + pixels(paper.width) + " " +
                    pixels(paper.height()) +
                    "\" role=\"img\" aria-label=\"Foreshortening and overlap by the C-arm's "
                    "angles; least in " +
                    angiogram::c_arm_label(view.best.angles) + "\">";
  out += draw_bands(map, paper) + draw_hatching(map, paper) + draw_axes(paper);
  if (!view.has_second)
    return out + draw_mark(paper, view.best, "best", NameSide::above) + "</svg>";
  const bool best_is_upper =
      view.best.angles.secondary_degrees >= view.second.angles.secondary_degrees;
  const NameSide best = best_is_upper ? NameSide::above : NameSide::below,
                 second = best_is_upper ? NameSide::below : NameSide::above;
  return out + draw_mark(paper, view.second, "second", second) +
         draw_mark(paper, view.best, "best", best) + "</svg>";
}

std::string view_map_for_page(const angiogram::WorkingView& view) {
  const std::string wide = view_map_svg(view, MapWidth::wide);
  if (wide.empty()) return {};
  return "<div class=\"on-wide\">" + wide + "</div><div class=\"on-narrow\">" +
         view_map_svg(view, MapWidth::narrow) + "</div>";
}

std::string view_map_key(const std::string& seen, const std::string& others) {
  std::string out = "<p class=\"sub\">Foreshortening of " + seen + ", light to dark [%]:";
  for (std::size_t b = 0; b < kBands.size(); ++b) {
    const std::string from = formats::fixed_text(kBands[b].from, 0);
    out += std::string(b > 0 ? "," : "") +
           " <span class=\"swatch\" style=\"background:" + std::string(kBands[b].color) +
           "\"></span>" +
           (b + 1 < kBands.size() ? from + " to " + formats::fixed_text(kBands[b + 1].from, 0)
                                  : from + " and more");
  }
  return out + "; <span class=\"swatch hatched\"></span>hatched: " + others +
         " overlap more than " + formats::fixed_text(kOverlapped, 0) + " % of it</p>\n";
}

}  // namespace angio::viewer::detail
