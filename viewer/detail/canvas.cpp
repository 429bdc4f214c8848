#include "viewer/detail/canvas.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace angio::viewer::detail {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCapital = 21.0;  // of the font at scale 1 [pixel]
constexpr int kShift = 4;          // OpenCV draws to 1/16 pixel

cv::Mat matrix_of(Picture& picture) {
  return {picture.height, picture.width, CV_8UC3, picture.rgb.data()};
}

cv::Scalar scalar(const Rgb& color) {
  return {double(color[0]), double(color[1]), double(color[2])};
}

cv::Point fixed_point(Spot spot) {
  constexpr double kScale = 1 << kShift;
  return {int(std::lround(spot.x * kScale)), int(std::lround(spot.y * kScale))};
}

/// The font knows ASCII only.
std::string drawable(const std::string& text) {
  std::string out;
  for (const char letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte >= 0x20 && byte < 0x7f)
      out += letter;
    else if ((byte & 0xc0) != 0x80)  // the first byte of a letter of several
      out += byte < 0x20 ? ' ' : '-';
  }
  return out;
}

cv::Size size_of(const std::string& text, double height) {
  int below = 0;
  return cv::getTextSize(drawable(text), kFont, height / kCapital, 1, &below);
}

}  // namespace

void Canvas::write(const std::string& text, Spot at, double height, const Rgb& color) {
  cv::Mat image = matrix_of(picture_);
  const int thickness = height > 12.0 ? 2 : 1;
  cv::putText(image, drawable(text), {int(std::lround(at.x)), int(std::lround(at.y))}, kFont,
              height / kCapital, scalar(color), thickness, cv::LINE_AA);
}

Box Canvas::text_box(const std::string& text, Spot at, double height) {
  constexpr double kRoom = 2.0;
  const cv::Size size = size_of(text, height);
  return {at.x - kRoom, at.y - height - kRoom, size.width + 2.0 * kRoom,
          1.3 * height + 2.0 * kRoom};
}

void Canvas::draw_line(const std::vector<Spot>& spots, const Rgb& color, int thickness) {
  cv::Mat image = matrix_of(picture_);
  for (std::size_t i = 0; i + 1 < spots.size(); ++i)
    cv::line(image, fixed_point(spots[i]), fixed_point(spots[i + 1]), scalar(color), thickness,
             cv::LINE_AA, kShift);
}

void Canvas::draw_circle(Spot middle, double radius, const Rgb& color, int thickness) {
  cv::Mat image = matrix_of(picture_);
  cv::circle(image, fixed_point(middle), int(std::lround(radius * (1 << kShift))), scalar(color),
             thickness, cv::LINE_AA, kShift);
}

void Canvas::fill(const Box& box, const Rgb& color) {
  cv::Mat image = matrix_of(picture_);
  cv::rectangle(
      image,
      cv::Rect(int(box.x), int(box.y), int(std::ceil(box.width)), int(std::ceil(box.height))),
      scalar(color), cv::FILLED);
}

void Canvas::place(const Picture& picture, const Box& box) {
  if (picture.width <= 0 || picture.height <= 0) return;
  const double scale = std::min({1.0, box.width / picture.width, box.height / picture.height});
  const cv::Size size(std::max(1, int(picture.width * scale)),
                      std::max(1, int(picture.height * scale)));
  const cv::Mat source(picture.height, picture.width, CV_8UC3,
                       const_cast<std::uint8_t*>(picture.rgb.data()));
  cv::Mat fitted;
  cv::resize(source, fitted, size, 0, 0, cv::INTER_AREA);
  cv::Mat image = matrix_of(picture_);
  fitted.copyTo(
      image(cv::Rect(int(box.x + 0.5 * (box.width - size.width)),
                     int(box.y + 0.5 * (box.height - size.height)), size.width, size.height)));
}

std::vector<std::string> wrap_text(const std::string& text, double width, double letter_height) {
  std::vector<std::string> lines;
  std::string line;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::string longer = line.empty() ? word : line + " " + word;
    if (!line.empty() && size_of(longer, letter_height).width > width) {
      lines.push_back(line);
      line = word;
    } else {
      line = longer;
    }
    begin = end + 1;
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

}  // namespace angio::viewer::detail
