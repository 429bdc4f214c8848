#pragma once

#include <string>
#include <vector>

#include "viewer/detail/picture.hpp"

namespace angio::viewer::detail {

/// A place on a picture [pixel], from its upper left corner.
struct Spot {
  double x = 0.0;
  double y = 0.0;
};

struct Box {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  double height = 0.0;
  [[nodiscard]] bool overlaps(const Box& other) const {
    return x < other.x + other.width && other.x < x + width && y < other.y + other.height &&
           other.y < y + height;
  }
};

/// Text and lines on a picture, smooth, with the font that OpenCV brings along: letters outside
/// ASCII are replaced.
class Canvas {
 public:
  explicit Canvas(Picture picture) : picture_(std::move(picture)) {}

  /// @param at      the text's lower left corner
  /// @param height  of a capital letter [pixel]
  void write(const std::string& text, Spot at, double height, const Rgb& color);
  /// What write() would cover.
  static Box text_box(const std::string& text, Spot at, double height);
  void draw_line(const std::vector<Spot>& spots, const Rgb& color, int thickness);
  void draw_circle(Spot middle, double radius, const Rgb& color, int thickness);  ///< -1: filled
  void fill(const Box& box, const Rgb& color);
  /// The picture in the middle of the box, shrunk (never enlarged) to fit.
  void place(const Picture& picture, const Box& box);

  [[nodiscard]] int width() const { return picture_.width; }
  [[nodiscard]] int height() const { return picture_.height; }
  [[nodiscard]] const Picture& picture() const { return picture_; }

 private:
  Picture picture_;
};

/// Lines no wider than so many pixels, broken at spaces.
std::vector<std::string> wrap_text(const std::string& text, double width, double letter_height);

}  // namespace angio::viewer::detail
