#include "viewer/detail/mark.hpp"

#include <algorithm>

namespace angio::viewer::detail {

MarkLayout lay_out_mark(const MarkRequest& request) {
  constexpr double kMostRing = 1.0 / 6.0;
  MarkLayout layout;
  layout.radius =
      std::min(request.radius, kMostRing * std::min(request.picture_width, request.picture_height));
  const double away = layout.radius + request.gap;
  const double most_left = std::max(0.0, request.picture_width - request.label_width);
  const double most_bottom = std::max(0.0, request.picture_height - request.label_height);
  const double right = request.x + away, left = request.x - away - request.label_width;
  const double above = request.y + away, below = request.y - away - request.label_height;
  const bool fits_right = right <= most_left, fits_left = left >= 0.0;
  const bool is_left_roomier = request.x > 0.5 * request.picture_width;
  if (fits_right || fits_left) {
    layout.label_left = fits_left && (is_left_roomier || !fits_right) ? left : right;
    layout.label_bottom = request.y - 0.5 * request.label_height;
  } else {
    layout.label_left = request.x - 0.5 * request.label_width;
    layout.label_bottom = above <= most_bottom ? above : below;
  }
  layout.label_left = std::clamp(layout.label_left, 0.0, most_left);
  layout.label_bottom = std::clamp(layout.label_bottom, 0.0, most_bottom);
  return layout;
}

}  // namespace angio::viewer::detail
