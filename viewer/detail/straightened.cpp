#include <algorithm>
#include <array>
#include <cmath>

#include "formats/text.hpp"
#include "viewer/detail/canvas.hpp"
#include "viewer/detail/grey_window.hpp"
#include "viewer/detail/moment_colors.hpp"
#include "viewer/detail/path_sections.hpp"
#include "viewer/detail/scale_length.hpp"
#include "viewer/detail/section_slider.hpp"

namespace angio::viewer::detail {
namespace {

constexpr int kSheetWidth = 920;  // [pixel], that the two planes fill
constexpr int kMostHeight = 420;  // of a plane above the other: a wider vessel's are side by side
constexpr int kLeastHeight = 40;  // [pixel]
constexpr int kEdgeStep = 3;      // columns between two places where edges are looked for
constexpr int kGap = 8;           // between the two planes [pixel]
constexpr int kScaleHeight = 26;  // below them [pixel]
constexpr double kLetterOfRow = 10.0;  // [pixel]
constexpr Rgb kInk{20, 20, 20};
constexpr std::uint8_t kNoScan = 26;

/// One plane through the straightened vessel: a column for each section.
struct Ribbon {
  int width = 0, height = 0;  ///< [pixel]
  double pixel_mm = 1.0;      ///< in both directions
  std::size_t axis = 0;       ///< across: 0 along the sections' "right", 1 along their "down"
};

Vec3 across(const PathSection& section, const Ribbon& ribbon) {
  return ribbon.axis == 0 ? section.window.right : section.window.down;
}

/// Shape [height, sections].
std::vector<float> sample_ribbon(const Volume<float>& volume,
                                 const std::vector<PathSection>& sections, const Ribbon& ribbon,
                                 float outside) {
  std::vector<float> values;
  for (int y = 0; y < ribbon.height; ++y)
    for (const PathSection& section : sections)
      values.push_back(
          sample_point(volume,
                       section.window.center + (ribbon.pixel_mm * (y - 0.5 * (ribbon.height - 1))) *
                                                   across(section, ribbon),
                       outside));
  return values;
}

Picture grey_picture(const std::vector<float>& values, const GreyWindow& grey,
                     const Ribbon& ribbon) {
  Picture picture{ribbon.width, ribbon.height, {}};
  if (values.empty()) {
    picture.rgb.assign(std::size_t(3 * ribbon.width * ribbon.height), kNoScan);
    return picture;
  }
  for (const float value : values) picture.rgb.insert(picture.rgb.end(), 3, grey.shade(value));
  return picture;
}

/// Both edges of the lumen; a line breaks where a section has none.
void draw_edges(Canvas& canvas, const TriangleMesh& lumen, const std::vector<PathSection>& sections,
                const Ribbon& ribbon, const Rgb& color) {
  std::array<std::vector<Spot>, 2> lines;
  const auto end_lines = [&] {
    for (std::vector<Spot>& line : lines) {
      if (line.size() > 1) canvas.draw_line(line, color, 1);
      line.clear();
    }
  };
  for (std::size_t column = 0; column < sections.size(); column += kEdgeStep) {
    const auto edges = nearest_edges(section_contours(lumen, sections[column].window), ribbon.axis);
    if (!edges) {
      end_lines();
      continue;
    }
    for (std::size_t side = 0; side < 2; ++side)
      lines[side].push_back(
          {double(column), 0.5 * (ribbon.height - 1) + (*edges)[side] / ribbon.pixel_mm});
  }
  end_lines();
}

/// One scale along and across the vessel, so that its stretch and its width both fit.
Ribbon fit(double length_mm, double width_mm, int most_width, int most_height) {
  Ribbon ribbon;
  ribbon.pixel_mm = std::max(length_mm / (most_width - 1), width_mm / most_height);
  ribbon.width = 1 + int(length_mm / ribbon.pixel_mm + 1e-9);
  ribbon.height = std::max(int(width_mm / ribbon.pixel_mm + 1e-9), kLeastHeight);
  return ribbon;
}

/// The two planes, and the sheet that they fill.
struct Layout {
  Ribbon ribbon;
  int step_x = 0, step_y = 0;  ///< from the first plane to the second [pixel]
  [[nodiscard]] int width() const { return ribbon.width + step_x; }
  [[nodiscard]] int height() const { return ribbon.height + step_y; }
};

/// A long thin vessel's planes lie above each other, a short wide one's side by side: either fills
/// the sheet's width.
Layout lay_out(double length_mm, double width_mm) {
  Layout layout;
  if (width_mm * (kSheetWidth - 1) <= length_mm * kMostHeight) {
    layout.ribbon = fit(length_mm, width_mm, kSheetWidth, kMostHeight);
    layout.step_y = layout.ribbon.height + kGap;
  } else {
    constexpr int kHalf = (kSheetWidth - kGap) / 2;
    layout.ribbon = fit(length_mm, width_mm, kHalf, kHalf);
    layout.step_x = layout.ribbon.width + kGap;
  }
  return layout;
}

/// Below the picture.
void draw_scale(Canvas& canvas, double pixel_mm) {
  const double length = scale_length(0.2 * canvas.width() * pixel_mm);
  const double y = canvas.height() - 8.0;
  canvas.draw_line({{4.0, y}, {4.0 + length / pixel_mm, y}}, kInk, 2);
  canvas.write(formats::number_text(length) + " mm", {12.0 + length / pixel_mm, y + 5.0},
               kLetterOfRow, kInk);
}

}  // namespace

std::vector<Figure> draw_straightened(const ReportContent& content) {
  const CenterlinePath* path = lesion_path(content);
  if (!path || content.lumen.triangles.empty()) return {};
  const std::vector<double> ends = places_around_lesion(content, *path, 3);
  if (!(ends.back() > ends.front())) return {};
  const Layout layout =
      lay_out(ends.back() - ends.front(),
              2.0 * path_sections(content, *path, ends).front().window.half_size_mm);
  std::array<Ribbon, 2> ribbons{layout.ribbon, layout.ribbon};
  ribbons[1].axis = 1;
  const double pixel_mm = layout.ribbon.pixel_mm;
  std::vector<double> places;
  for (int x = 0; x < layout.ribbon.width; ++x) places.push_back(ends.front() + x * pixel_mm);
  const auto sections = path_sections(content, *path, places);
  std::array<std::vector<float>, 2> values;
  GreyWindow grey;
  if (content.volume) {
    const float outside = lowest(content.volume->values);
    for (std::size_t r = 0; r < 2; ++r)
      values[r] = sample_ribbon(*content.volume, sections, ribbons[r], outside);
    std::vector<float> all = values[0];
    all.insert(all.end(), values[1].begin(), values[1].end());
    grey = window_of(all);
  }
  const TriangleMesh before = near_sections(content.lumen, sections);
  Picture sheet = blank_picture(layout.width(), layout.height() + kScaleHeight);
  for (std::size_t r = 0; r < 2; ++r) {
    Canvas canvas(grey_picture(values[r], grey, ribbons[r]));
    draw_edges(canvas, before, sections, ribbons[r], moment_colors::kBefore);
    if (content.moments.size() > 1)
      draw_edges(canvas, content.moments.back().wall, sections, ribbons[r], moment_colors::kAfter);
    paste(canvas.picture(), int(r) * layout.step_x, int(r) * layout.step_y, sheet);
  }
  Canvas labelled(std::move(sheet));
  draw_scale(labelled, pixel_mm);
  return {{"straightened.png",
           "The vessel as if it were straight, flow from left to right, in two planes at right "
           "angles to each other; blue: the lumen's edge before, orange: after.",
           labelled.picture()}};
}

}  // namespace angio::viewer::detail
