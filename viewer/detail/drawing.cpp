#include "viewer/detail/drawing.hpp"

#include <array>
#include <cmath>
#include <vector>

namespace angio::viewer::detail {

cv::Scalar cv_color(const Rgb& color) {
  return {double(color[0]), double(color[1]), double(color[2])};
}

cv::Point fixed_point(double x, double y) {
  constexpr double kScale = 1 << kDrawingShift;
  return {int(std::lround(x * kScale)), int(std::lround(y * kScale))};
}

Picture to_picture(const cv::Mat& image) {
  Picture picture{image.cols, image.rows, {}};
  for (int row = 0; row < image.rows; ++row)
    picture.rgb.insert(picture.rgb.end(), image.ptr(row), image.ptr(row) + 3 * image.cols);
  return picture;
}

void draw_text(cv::Mat& picture, const std::string& text, cv::Point at, double size) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {255, 255, 255}, 1, cv::LINE_AA);
}

void draw_shadow_outline(cv::Mat& picture, const TriangleMesh& mesh,
                         const std::vector<Spot>& places, const Rgb& color) {
  cv::Mat shadow = cv::Mat::zeros(picture.rows, picture.cols, CV_8UC1);
  for (const Triangle& t : mesh.triangles) {
    std::array<cv::Point, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const Spot& spot = places[std::size_t(t[k])];
      corners[k] = fixed_point(spot.x, spot.y);
    }
    cv::fillConvexPoly(shadow, corners.data(), 3, 255, cv::LINE_8, kDrawingShift);
  }
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(shadow, outlines, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  cv::drawContours(picture, outlines, -1, cv_color(color), 1, cv::LINE_AA);
}

}  // namespace angio::viewer::detail
