#include <algorithm>
#include <array>
#include <cmath>

#include "formats/text.hpp"
#include "viewer/detail/canvas.hpp"
#include "viewer/detail/grey_window.hpp"
#include "viewer/detail/path_sections.hpp"
#include "viewer/detail/scale_length.hpp"
#include "viewer/detail/section_slider.hpp"

namespace angio::viewer::detail {
namespace {

constexpr int kMostWidth = 920;       // [pixel]
constexpr int kMostHeight = 300;      // [pixel]
constexpr int kEdgeStep = 3;          // columns between two places where edges are looked for
constexpr int kGap = 6;               // between the two planes [pixel]
constexpr double kLetter = 10.0;      // [pixel]
constexpr Rgb kBefore{70, 200, 255};  // as in the other sections
constexpr Rgb kAfter{255, 160, 40};
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
Ribbon fit(double length_mm, double half_size_mm) {
  Ribbon ribbon;
  ribbon.pixel_mm = std::max(length_mm / (kMostWidth - 1), 2.0 * half_size_mm / kMostHeight);
  ribbon.width = 1 + int(length_mm / ribbon.pixel_mm + 1e-9);
  ribbon.height = std::max(int(2.0 * half_size_mm / ribbon.pixel_mm + 1e-9), 40);
  return ribbon;
}

/// Below the picture.
void draw_scale(Canvas& canvas, double pixel_mm) {
  const double length = scale_length(0.2 * canvas.width() * pixel_mm);
  const double y = canvas.height() - 8.0;
  canvas.draw_line({{4.0, y}, {4.0 + length / pixel_mm, y}}, kInk, 2);
  canvas.write(formats::number_text(length) + " mm", {12.0 + length / pixel_mm, y + 5.0}, kLetter,
               kInk);
}

}  // namespace

std::vector<Figure> draw_straightened(const ReportContent& content) {
  const CenterlinePath* path = lesion_path(content);
  if (!path || content.lumen.triangles.empty()) return {};
  const std::vector<double> ends = places_around_lesion(content, *path, 3);
  if (!(ends.back() > ends.front())) return {};
  std::array<Ribbon, 2> ribbons;
  ribbons.fill(fit(ends.back() - ends.front(),
                   path_sections(content, *path, ends).front().window.half_size_mm));
  ribbons[1].axis = 1;
  const int width = ribbons[0].width, height = ribbons[0].height;
  const double pixel_mm = ribbons[0].pixel_mm;
  std::vector<double> places;
  for (int x = 0; x < width; ++x) places.push_back(ends.front() + x * pixel_mm);
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
  Picture sheet = blank_picture(kMostWidth, 2 * height + kGap + 26);
  for (std::size_t r = 0; r < 2; ++r) {
    Canvas canvas(grey_picture(values[r], grey, ribbons[r]));
    draw_edges(canvas, before, sections, ribbons[r], kBefore);
    if (content.moments.size() > 1)
      draw_edges(canvas, content.moments.back().wall, sections, ribbons[r], kAfter);
    paste(canvas.picture(), 0, int(r) * (height + kGap), sheet);
  }
  Canvas labelled(std::move(sheet));
  draw_scale(labelled, pixel_mm);
  return {{"straightened.png",
           "The vessel as if it were straight, flow from left to right, in two planes at right "
           "angles to each other; blue: the lumen's edge before, orange: after.",
           labelled.picture()}};
}

}  // namespace angio::viewer::detail
