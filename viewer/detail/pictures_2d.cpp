#include "viewer/detail/pictures_2d.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "formats/text.hpp"
#include "viewer/detail/drawing.hpp"
#include "viewer/detail/grey_window.hpp"
#include "viewer/detail/moment_colors.hpp"
#include "viewer/detail/path_sections.hpp"
#include "viewer/detail/plane.hpp"
#include "viewer/detail/projection.hpp"
#include "viewer/detail/scale_length.hpp"

namespace angio::viewer::detail {
namespace {

constexpr int kProjectionPixels = 420;
constexpr int kSlicePixels = 380;
constexpr int kTilePixels = 202;
constexpr int kTileColumns = 5;
constexpr int kTileRows = 3;       // an odd number of tiles: the lesion is in the middle
constexpr float kHeadroom = 0.4f;  // vessels are not drawn white: their outline must be seen

/// @param values  shape [height, width]
cv::Mat grey_picture(const std::vector<float>& values, int width, int height,
                     const GreyWindow& window) {
  cv::Mat picture(height, width, CV_8UC3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint8_t level =
          window.shade(values[std::size_t(y) * std::size_t(width) + std::size_t(x)]);
      picture.at<cv::Vec3b>(y, x) = {level, level, level};
    }
  return picture;
}

void draw_contour(cv::Mat& picture, const TriangleMesh& mesh, const PlaneWindow& window,
                  const Rgb& color) {
  const Vec3 normal = cross(window.right, window.down);
  for (const Segment& segment : cut(mesh, window.center, normal)) {
    const auto a = window.pixel_of(segment[0], picture.cols);
    const auto b = window.pixel_of(segment[1], picture.cols);
    const double far = 4.0 * picture.cols;
    if (std::max({std::abs(a.x), std::abs(a.y), std::abs(b.x), std::abs(b.y)}) > far) continue;
    cv::line(picture, fixed_point(a.x, a.y), fixed_point(b.x, b.y), cv_color(color), 1, cv::LINE_AA,
             kDrawingShift);
  }
}

/// A bar of a round length at the lower left.
void draw_scale(cv::Mat& picture, double mm_per_pixel) {
  const double length_mm = scale_length(0.3 * picture.cols * mm_per_pixel);
  const int length = int(std::lround(length_mm / mm_per_pixel));
  const int y = picture.rows - 10;
  cv::line(picture, {10, y}, {10 + length, y}, {0, 0, 0}, 4);
  cv::line(picture, {10, y}, {10 + length, y}, {255, 255, 255}, 2);
  draw_text(picture, formats::number_text(length_mm) + " mm", {10, y - 7}, 0.42);
}

/// The letters of the patient's sides at the edges.
void draw_sides(cv::Mat& picture, const std::string& name) {
  const bool is_sagittal = name == "sagittal";
  const char* left = is_sagittal ? "A" : "R";
  const char* right = is_sagittal ? "P" : "L";
  const char* top = name == "axial" ? "A" : "H";
  draw_text(picture, left, {4, picture.rows / 2}, 0.5);
  draw_text(picture, right, {picture.cols - 16, picture.rows / 2}, 0.5);
  draw_text(picture, top, {picture.cols / 2 - 5, 16}, 0.5);
}

/// The outline of the lumen's shadow on a projection.
void draw_silhouette(cv::Mat& picture, const Projection& projection, const TriangleMesh& lumen,
                     const VolumeGeometry& grid, double scale_x, double scale_y) {
  std::vector<Spot> places(lumen.vertices.size());
  for (std::size_t v = 0; v < places.size(); ++v) {
    const auto pixel = projection.pixel_of(grid.index_from_lps(lumen.vertices[v]));
    places[v] = {(pixel.x + 0.5) * scale_x - 0.5, (pixel.y + 0.5) * scale_y - 0.5};
  }
  draw_shadow_outline(picture, lumen, places, moment_colors::kBefore);
}

std::string capitalized(std::string word) {
  if (!word.empty()) word[0] = char(std::toupper(static_cast<unsigned char>(word[0])));
  return word;
}

/// A projection on a square; all three share one scale.
Figure draw_projection(const Projection& projection, const ReportContent& content,
                       double pixels_per_mm) {
  const auto pixels = [&](double mm) {
    return std::clamp(int(std::lround(mm * pixels_per_mm)), 1, kProjectionPixels);
  };
  const cv::Size size(pixels(projection.width * projection.pixel_width_mm),
                      pixels(projection.height * projection.pixel_height_mm));
  GreyWindow grey = window_of(projection.values);
  grey.white += kHeadroom * (grey.white - grey.black);
  cv::Mat picture = grey_picture(projection.values, projection.width, projection.height, grey);
  const bool is_larger = size.width >= projection.width && size.height >= projection.height;
  cv::resize(picture, picture, size, 0, 0, is_larger ? cv::INTER_LINEAR : cv::INTER_AREA);
  draw_silhouette(picture, projection, content.lumen, content.volume->geometry,
                  double(size.width) / projection.width, double(size.height) / projection.height);
  cv::Mat square(kProjectionPixels, kProjectionPixels, CV_8UC3, cv::Scalar(0, 0, 0));
  picture.copyTo(square(cv::Rect((kProjectionPixels - size.width) / 2,
                                 (kProjectionPixels - size.height) / 2, size.width, size.height)));
  draw_scale(square, 1.0 / pixels_per_mm);
  draw_sides(square, projection.name);
  return {"projection_" + projection.name + ".png", capitalized(projection.name) + " projection",
          to_picture(square)};
}

}  // namespace

std::vector<Figure> draw_projections(const ReportContent& content) {
  std::vector<Figure> figures;
  if (!content.volume) return figures;
  constexpr double kMarginMm = 10.0;
  const VoxelBox box = box_around(content.volume->geometry, content.lumen.vertices, kMarginMm);
  const std::vector<Projection> projections = project_maximum(*content.volume, box);
  double longest_mm = 0.0;
  for (const Projection& projection : projections)
    longest_mm = std::max({longest_mm, projection.width * projection.pixel_width_mm,
                           projection.height * projection.pixel_height_mm});
  for (const Projection& projection : projections)
    figures.push_back(draw_projection(projection, content, kProjectionPixels / longest_mm));
  return figures;
}

std::vector<Figure> draw_slices(const ReportContent& content) {
  const CenterlinePath* path = lesion_path(content);
  if (!content.volume || !path) return {};
  const CenterlineSample lesion = sample(*path, content.lesion_abscissa_mm);
  const double reach = shown_reach(content, *path);
  const double half_size =
      std::max(reach, 4.0 * widest_near(*path, content.lesion_abscissa_mm, reach));
  struct Named {
    const char* name;
    Vec3 right, down;
  };
  const std::array<Named, 3> named{{{"axial", {1, 0, 0}, {0, 1, 0}},
                                    {"coronal", {1, 0, 0}, {0, 0, -1}},
                                    {"sagittal", {0, 1, 0}, {0, 0, -1}}}};
  std::vector<PlaneWindow> windows;
  std::vector<std::vector<float>> sampled;
  std::vector<float> all;
  const float outside = lowest(content.volume->values);
  for (const Named& slice : named) {
    windows.push_back({lesion.point, slice.right, slice.down, half_size});
    sampled.push_back(sample_plane(*content.volume, windows.back(), kSlicePixels, outside));
    all.insert(all.end(), sampled.back().begin(), sampled.back().end());
  }
  const GreyWindow grey = window_of(all);
  std::vector<Figure> figures;
  for (std::size_t i = 0; i < named.size(); ++i) {
    cv::Mat picture = grey_picture(sampled[i], kSlicePixels, kSlicePixels, grey);
    draw_contour(picture, content.lumen, windows[i], moment_colors::kBefore);
    draw_scale(picture, 2.0 * half_size / kSlicePixels);
    draw_sides(picture, named[i].name);
    figures.push_back({std::string("slice_") + named[i].name + ".png",
                       capitalized(named[i].name) + " slice through the " + site_name(content),
                       to_picture(picture)});
  }
  return figures;
}

std::vector<Figure> draw_contact_sheet(const ReportContent& content) {
  const CenterlinePath* path = lesion_path(content);
  if (!path || content.lumen.triangles.empty()) return {};
  const std::vector<PathSection> places =
      path_sections(content, *path, places_around_lesion(content, *path, kTileColumns * kTileRows));
  std::vector<std::vector<float>> sampled;
  std::vector<float> all;
  if (content.volume) {
    const float outside = lowest(content.volume->values);
    for (const PathSection& place : places) {
      sampled.push_back(sample_plane(*content.volume, place.window, kTilePixels, outside));
      all.insert(all.end(), sampled.back().begin(), sampled.back().end());
    }
  }
  const GreyWindow grey = window_of(all);
  constexpr int kGap = 3;
  cv::Mat sheet(kTileRows * (kTilePixels + kGap) - kGap, kTileColumns * (kTilePixels + kGap) - kGap,
                CV_8UC3, cv::Scalar(255, 255, 255));
  for (std::size_t i = 0; i < places.size(); ++i) {
    cv::Mat tile = content.volume ? grey_picture(sampled[i], kTilePixels, kTilePixels, grey)
                                  : cv::Mat(kTilePixels, kTilePixels, CV_8UC3, {24, 26, 30});
    draw_contour(tile, content.lumen, places[i].window, moment_colors::kBefore);
    if (content.moments.size() > 1)
      draw_contour(tile, content.moments.back().wall, places[i].window, moment_colors::kAfter);
    draw_text(tile,
              formats::fixed_text(places[i].abscissa_mm - content.lesion_abscissa_mm, 1) + " mm",
              {6, 15}, 0.42);
    if (i == 0) draw_scale(tile, 2.0 * places[i].window.half_size_mm / kTilePixels);
    const int column = int(i) % kTileColumns, row = int(i) / kTileColumns;
    tile.copyTo(sheet(cv::Rect(column * (kTilePixels + kGap), row * (kTilePixels + kGap),
                               kTilePixels, kTilePixels)));
  }
  return {{"cross_sections.png",
           "Cross-sections at right angles to the vessel, along the flow; the numbers are the "
           "distance from the place that is treated.",
           to_picture(sheet)}};
}

}  // namespace angio::viewer::detail
