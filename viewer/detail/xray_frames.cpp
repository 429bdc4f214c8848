#include "viewer/detail/xray_frames.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "viewer/detail/canvas.hpp"
#include "viewer/detail/drawing.hpp"
#include "viewer/detail/grey_window.hpp"

namespace angio::viewer::detail {
namespace {

constexpr Rgb kOutline{255, 90, 30};
constexpr Rgb kInk{20, 20, 20};
constexpr double kLetter = 11.0;  // [pixel]
constexpr int kTile = 360;        // [pixel]
constexpr int kGround = 200;
constexpr double kBroad = 0.125;  // of the shorter side: wider than vessels, narrower than bones

std::vector<float> without_ground(const XrayPicture& picture) {
  std::vector<float> values = picture.attenuation;
  if (picture.is_subtracted) return values;
  cv::Mat image(picture.place.rows, picture.place.columns, CV_32FC1, values.data());
  cv::Mat broad;
  const double sigma = kBroad * std::min(image.rows, image.cols);
  cv::GaussianBlur(image, broad, {}, sigma, sigma, cv::BORDER_REPLICATE);
  image -= broad;
  return values;
}

/// @param scale  of the tile's pixels in the picture's
std::vector<Spot> seen_places(const TriangleMesh& mesh, const angiogram::ConeBeamFrame& frame,
                              double scale) {
  const angiogram::ConeBeamView view(frame);
  std::vector<Spot> places;
  places.reserve(mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) {
    const angiogram::SeenPoint seen = view.see(vertex);
    places.push_back({(seen.column + 0.5) * scale - 0.5, (seen.row + 0.5) * scale - 0.5});
  }
  return places;
}

cv::Mat negative(const std::vector<float>& values, int columns, int rows,
                 const GreyWindow& window) {
  cv::Mat image(rows, columns, CV_8UC1);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      image.at<std::uint8_t>(y, x) = std::uint8_t(
          255 - window.shade(values[std::size_t(y) * std::size_t(columns) + std::size_t(x)]));
  cv::cvtColor(image, image, cv::COLOR_GRAY2RGB);
  return image;
}

Figure draw_frame(const XrayPicture& picture, const std::vector<float>& values,
                  const GreyWindow& window, const TriangleMesh& lumen, int number) {
  const int columns = picture.place.columns, rows = picture.place.rows;
  const double scale = double(kTile) / std::max(columns, rows);
  cv::Mat image = negative(values, columns, rows, window);
  const cv::Size size(std::max(1, int(columns * scale)), std::max(1, int(rows * scale)));
  cv::resize(image, image, size, 0.0, 0.0, scale > 1.0 ? cv::INTER_CUBIC : cv::INTER_AREA);
  draw_shadow_outline(image, lumen, seen_places(lumen, picture.place, scale), kOutline);
  cv::Mat tile(kTile, kTile, CV_8UC3, cv::Scalar::all(kGround));
  image.copyTo(
      tile({(kTile - size.width) / 2, (kTile - size.height) / 2, size.width, size.height}));
  return {xray_file(number), picture.title, to_picture(tile)};
}

}  // namespace

std::string xray_file(int number) { return "frame_" + std::to_string(number) + ".png"; }

std::vector<Figure> draw_xray_frames(const ReportContent& content) {
  std::vector<std::vector<float>> shown;
  std::vector<float> all;
  for (const XrayPicture& picture : content.frames) {
    shown.push_back(without_ground(picture));
    all.insert(all.end(), shown.back().begin(), shown.back().end());
  }
  if (all.empty()) return {};
  const GreyWindow window = window_of(all);
  std::vector<Figure> figures;
  for (std::size_t n = 0; n < shown.size(); ++n)
    figures.push_back(draw_frame(content.frames[n], shown[n], window, content.lumen, int(n) + 1));
  return figures;
}

Picture sheet_of(const std::vector<Figure>& figures) {
  constexpr int kColumns = 4, kGap = 4;
  const int count = int(figures.size()), across = std::min(count, kColumns);
  const int width = figures.front().picture.width + kGap,
            height = figures.front().picture.height + kGap;
  Canvas sheet(
      blank_picture(across * width - kGap, (count + kColumns - 1) / kColumns * height - kGap));
  for (int n = 0; n < count; ++n) {
    const int column = n % kColumns, row = n / kColumns;
    const double left = column * width, top = row * height;
    const Picture& tile = figures[std::size_t(n)].picture;
    sheet.place(tile, {left, top, double(tile.width), double(tile.height)});
    sheet.write(figures[std::size_t(n)].caption, {left + 8.0, top + 20.0}, kLetter, kInk);
  }
  return sheet.picture();
}

}  // namespace angio::viewer::detail
