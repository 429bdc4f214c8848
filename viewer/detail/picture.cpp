#include "viewer/detail/picture.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"

namespace angio::viewer::detail {
namespace {

Picture from_cv_rgb(const cv::Mat& image) {
  Picture picture{image.cols, image.rows, {}};
  picture.rgb.reserve(std::size_t(image.cols) * std::size_t(image.rows) * 3);
  for (int row = 0; row < image.rows; ++row)
    picture.rgb.insert(picture.rgb.end(), image.ptr(row), image.ptr(row) + 3 * image.cols);
  return picture;
}

}  // namespace

Picture shrink(const Picture& picture, int factor) {
  Picture small{picture.width / factor, picture.height / factor, {}};
  small.rgb.resize(std::size_t(small.width) * std::size_t(small.height) * 3);
  const int half = factor * factor / 2;
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int dy = 0; dy < factor; ++dy)
          for (int dx = 0; dx < factor; ++dx)
            sum += picture.rgb[std::size_t(
                ((y * factor + dy) * picture.width + x * factor + dx) * 3 + c)];
        small.rgb[std::size_t((y * small.width + x) * 3 + c)] =
            std::uint8_t((sum + half) / (factor * factor));
      }
  return small;
}

Picture blank_picture(int width, int height) {
  return {width, height,
          std::vector<std::uint8_t>(std::size_t(width) * std::size_t(height) * 3, 255)};
}

void paste(const Picture& picture, int left, int top, Picture& onto) {
  ANGIO_EXPECT(left >= 0 && top >= 0 && left + picture.width <= onto.width &&
               top + picture.height <= onto.height);
  const std::size_t row_bytes = std::size_t(picture.width) * 3;
  for (int row = 0; row < picture.height; ++row)
    std::copy_n(picture.rgb.data() + std::size_t(row) * row_bytes, row_bytes,
                onto.rgb.data() +
                    (std::size_t(top + row) * std::size_t(onto.width) + std::size_t(left)) * 3);
}

std::string png_bytes(const Picture& picture) {
  ANGIO_EXPECT(picture.rgb.size() == std::size_t(picture.width) * std::size_t(picture.height) * 3);
  const cv::Mat rgb(picture.height, picture.width, CV_8UC3,
                    const_cast<std::uint8_t*>(picture.rgb.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", bgr, bytes, {cv::IMWRITE_PNG_COMPRESSION, 9});
  return {bytes.begin(), bytes.end()};
}

Picture picture_from_png(const std::string& bytes) {
  const std::vector<std::uint8_t> raw(bytes.begin(), bytes.end());
  const cv::Mat bgr = raw.empty() ? cv::Mat() : cv::imdecode(raw, cv::IMREAD_COLOR);
  if (bgr.empty()) throw InputError("not a PNG picture (it is damaged). Write it again");
  cv::Mat rgb;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return from_cv_rgb(rgb);
}

}  // namespace angio::viewer::detail
