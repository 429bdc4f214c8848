#include <algorithm>
#include <cmath>

#include "formats/text.hpp"
#include "viewer/detail/chart.hpp"
#include "viewer/detail/figure.hpp"
#include "viewer/detail/sheet_pictures.hpp"

namespace angio::viewer::detail {
namespace {

constexpr Rgb kGrid{222, 226, 232};
constexpr Rgb kBeforeCurve{45, 130, 225};
constexpr Rgb kAfterCurve{235, 130, 20};
constexpr Rgb kReference{90, 98, 110};

/// Millimetres to pixels, with axes.
class Plot {
 public:
  Plot(int width, int height, double longest_mm, double widest_mm)
      : canvas_(blank_picture(width, height)),
        area_{52.0, 34.0, width - 70.0, height - 78.0},
        x_ticks_(round_ticks(0.0, std::max(longest_mm, 1e-3), 8)),
        y_ticks_(round_ticks(0.0, std::max(widest_mm, 1e-3), 5)) {
    draw_axes();
  }
  [[nodiscard]] Spot spot(double x, double y) const {
    return {area_.x + area_.width * x / x_ticks_.back(),
            area_.y + area_.height * (1.0 - y / y_ticks_.back())};
  }
  void draw_curve(const std::vector<double>& x, const std::vector<double>& y, const Rgb& color) {
    std::vector<Spot> spots;
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
      if (std::isfinite(x[i]) && std::isfinite(y[i])) spots.push_back(spot(x[i], y[i]));
    canvas_.draw_line(spots, color, 2);
  }
  Canvas& canvas() { return canvas_; }

 private:
  void draw_axes() {
    const auto label = [](const std::vector<double>& ticks, double tick) {
      return formats::fixed_text(tick, tick_decimals(ticks[1] - ticks[0]));
    };
    for (const double tick : x_ticks_) {
      canvas_.draw_line({spot(tick, 0.0), spot(tick, y_ticks_.back())}, kGrid, 1);
      const std::string text = label(x_ticks_, tick);
      const Box box = Canvas::text_box(text, {}, kSheetLetters);
      canvas_.write(text, {spot(tick, 0.0).x - 0.5 * box.width, spot(0.0, 0.0).y + 16.0},
                    kSheetLetters, kSheetInk);
    }
    for (const double tick : y_ticks_) {
      canvas_.draw_line({spot(0.0, tick), spot(x_ticks_.back(), tick)}, kGrid, 1);
      const std::string text = label(y_ticks_, tick);
      const Box box = Canvas::text_box(text, {}, kSheetLetters);
      canvas_.write(text, {area_.x - box.width - 4.0, spot(0.0, tick).y + 4.0}, kSheetLetters,
                    kSheetInk);
    }
    canvas_.write("distance from the inlet [mm]",
                  {area_.x + 0.5 * area_.width - 90.0, area_.y + area_.height + 36.0},
                  kSheetLetters, kSheetInk);
  }

  Canvas canvas_;
  Box area_;
  std::vector<double> x_ticks_, y_ticks_;
};

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, value);
  return most;
}

void draw_lesions(Plot& plot, const std::vector<SheetLesion>& lesions, int path) {
  for (const SheetLesion& lesion : lesions) {
    if (lesion.path != path) continue;
    const double first =
        std::isfinite(lesion.proximal_mm) ? lesion.proximal_mm : lesion.abscissa_mm;
    const double last = std::isfinite(lesion.distal_mm) ? lesion.distal_mm : lesion.abscissa_mm;
    if (std::isfinite(lesion.reference_mm)) {
      const double room = std::max(1.0, 0.5 * (last - first));
      plot.canvas().draw_line({plot.spot(std::max(0.0, first - room), lesion.reference_mm),
                               plot.spot(last + room, lesion.reference_mm)},
                              kReference, 1);
    }
    const Spot at =
        plot.spot(lesion.abscissa_mm, std::isfinite(lesion.mld_mm) ? lesion.mld_mm : 0.0);
    plot.canvas().draw_circle(at, 6.0, kSheetLesion, 2);
    plot.canvas().write(lesion.name, {at.x + 8.0, at.y + 12.0}, kSheetLetters, kSheetLesion);
  }
}

}  // namespace

Picture draw_diameters(const SheetCase& sheet, int width, int height) {
  const ReportContent& content = sheet.content;
  const CenterlinePath* path = lesion_path(content);
  if (!path) {
    Canvas canvas(blank_picture(width, height));
    canvas.write("no line to show the diameter of", {20.0, 0.5 * height}, 11.0, kSheetInk);
    return canvas.picture();
  }
  std::vector<double> diameter;
  for (const double radius : path->inscribed_radius) diameter.push_back(2.0 * radius);
  double widest = std::max(largest(diameter), largest(content.after.inscribed_diameter_mm));
  for (const SheetLesion& lesion : sheet.lesions)
    if (lesion.path == path->id && std::isfinite(lesion.reference_mm))
      widest = std::max(widest, lesion.reference_mm);
  Plot plot(width, height, path->abscissa.back(), widest);
  plot.draw_curve(path->abscissa, diameter, kBeforeCurve);
  plot.draw_curve(content.after.abscissa_mm, content.after.inscribed_diameter_mm, kAfterCurve);
  draw_lesions(plot, sheet.lesions, path->id);
  plot.canvas().write("diameter [mm] along line " + std::to_string(path->id) + ":", kHeading,
                      kSheetLetters, kSheetInk);
  plot.canvas().write("before", {220.0, kHeading.y}, kSheetLetters, kBeforeCurve);
  plot.canvas().write(content.after.abscissa_mm.empty() ? "no result after" : "after",
                      {285.0, kHeading.y}, kSheetLetters,
                      content.after.abscissa_mm.empty() ? kReference : kAfterCurve);
  plot.canvas().write("grey: healthy diameter at a lesion", {430.0, kHeading.y}, kSheetLetters,
                      kReference);
  return plot.canvas().picture();
}

}  // namespace angio::viewer::detail
