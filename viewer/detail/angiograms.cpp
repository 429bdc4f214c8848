#include "viewer/detail/angiograms.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/statistics.hpp"
#include "formats/text.hpp"
#include "viewer/detail/canvas.hpp"
#include "viewer/detail/scale_length.hpp"

namespace angio::viewer::detail {
namespace {

constexpr Rgb kInk{20, 20, 20};
constexpr Rgb kPaper{228, 228, 228};
constexpr double kGround = 228.0, kDarkest = 24.0;  // greys of no contrast medium and of the most
constexpr double kShown = 0.001;  // the darkest thousandth of the pixels is not told apart
constexpr double kLetter = 11.0;  // [pixel]

/// What is left of the beam where the pictures are darkest.
double darkest(const std::vector<Angiogram>& angiograms) {
  double least = 0.99;
  for (const Angiogram& angiogram : angiograms)
    least = std::min(least, quantile(angiogram.transmission, kShown, 1.0));
  return least;
}

Picture grey_picture(const Angiogram& angiogram, double least) {
  Picture picture{angiogram.pixels, angiogram.pixels, {}};
  for (const double left : angiogram.transmission) {
    const double share = std::clamp((left - least) / (1.0 - least), 0.0, 1.0);
    const auto grey = std::uint8_t(std::lround(kDarkest + share * (kGround - kDarkest)));
    picture.rgb.insert(picture.rgb.end(), {grey, grey, grey});
  }
  return picture;
}

/// On a label, so that it reads over a vessel.
void write(Canvas& canvas, const std::string& words, Spot at) {
  canvas.fill(Canvas::text_box(words, at, kLetter), kPaper);
  canvas.write(words, at, kLetter, kInk);
}

/// A quarter of the picture long at most.
void draw_scale(Canvas& canvas, double pixel_mm) {
  const double length_mm = scale_length(0.25 * canvas.width() * pixel_mm);
  const double length = length_mm / pixel_mm, y = canvas.height() - 14.0;
  canvas.draw_line({{14.0, y}, {14.0 + length, y}}, kInk, 2);
  write(canvas, formats::number_text(length_mm) + " mm", {14.0, y - 8.0});
}

/// An arrow from the upper left to the middle, where the lesion is; pale around, so that it reads
/// over a vessel.
void draw_arrow(Canvas& canvas) {
  const double middle = 0.5 * canvas.width(), tip = middle - 0.035 * canvas.width(),
               tail = middle - 0.09 * canvas.width(), wing = 0.018 * canvas.width();
  for (const auto& [color, width] : {std::pair(kPaper, 5), std::pair(kInk, 2)}) {
    canvas.draw_line({{tail, tail}, {tip, tip}}, color, width);
    canvas.draw_line({{tip - wing, tip}, {tip, tip}, {tip, tip - wing}}, color, width);
  }
}

}  // namespace

std::vector<Figure> draw_angiograms(const ReportContent& content) {
  std::vector<Figure> figures;
  const double least = darkest(content.views.angiograms);
  for (const Angiogram& angiogram : content.views.angiograms) {
    Canvas canvas(grey_picture(angiogram, least));
    write(canvas, angiogram.title, {14.0, 14.0 + kLetter});
    draw_scale(canvas, angiogram.pixel_mm);
    draw_arrow(canvas);
    figures.push_back({"angiogram_" + std::to_string(figures.size() + 1) + ".png", angiogram.title,
                       canvas.picture()});
  }
  return figures;
}

}  // namespace angio::viewer::detail
