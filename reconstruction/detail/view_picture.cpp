#include "reconstruction/detail/view_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace angio::reconstruction::detail {

/// The nearest line pixel of each pixel, passed on from neighbour to neighbour (Danielsson, Comput.
/// Graph. Image Process. 14:227, 1980).
void find_nearest(ViewPicture& picture) {
  const int columns = picture.lines.columns, rows = picture.lines.rows;
  picture.nearest.assign(picture.lines.radius.size(), -1);
  picture.distance.assign(picture.lines.radius.size(), 1e9F);
  const auto at = [columns](int c, int r) {
    return std::size_t(r) * std::size_t(columns) + std::size_t(c);
  };
  for (std::size_t i = 0; i < picture.nearest.size(); ++i)
    if (picture.lines.radius[i] > 0.0F) {
      picture.nearest[i] = int(i);
      picture.distance[i] = 0.0F;
    }
  const auto take = [&](int c, int r, int dx, int dy) {
    if (c + dx < 0 || c + dx >= columns || r + dy < 0 || r + dy >= rows) return;
    const int seed = picture.nearest[at(c + dx, r + dy)];
    if (seed < 0) return;
    const float far = std::hypot(float(seed % columns - c), float(seed / columns - r));
    if (far < picture.distance[at(c, r)]) {
      picture.distance[at(c, r)] = far;
      picture.nearest[at(c, r)] = seed;
    }
  };
  for (int pass = 0; pass < 2; ++pass) {
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c)
        for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}})
          take(c, r, dx, dy);
      for (int c = columns - 1; c >= 0; --c) take(c, r, 1, 0);
    }
    for (int r = rows - 1; r >= 0; --r) {
      for (int c = columns - 1; c >= 0; --c)
        for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) take(c, r, dx, dy);
      for (int c = 0; c < columns; ++c) take(c, r, -1, 0);
    }
  }
}

ViewPicture make_view_picture(const angiogram::ConeBeamFrame& frame, std::vector<float> vessels,
                              const std::vector<char>& covered, double widest_mm) {
  ViewPicture picture;
  picture.frame = frame;
  picture.pixel_mm = std::sqrt(norm(frame.column_step) * norm(frame.row_step));
  const double at_isocentre =
      picture.pixel_mm * angiogram::ConeBeamView(frame).see(Vec3{0.0, 0.0, 0.0}).depth;
  picture.lines = find_vessel_lines(vessels, frame.columns, frame.rows, widest_mm / at_isocentre);
  for (std::size_t i = 0; i < covered.size(); ++i)
    if (covered[i] != 0) picture.lines.radius[i] = 0.0F;
  picture.vessels = std::move(vessels);
  find_nearest(picture);
  return picture;
}

double pixel_at_isocentre(const angiogram::ConeBeamFrame& frame) {
  return norm(frame.column_step) * angiogram::ConeBeamView(frame).see(Vec3{0.0, 0.0, 0.0}).depth;
}

double finest_pixel(const std::vector<angiogram::ConeBeamFrame>& frames) {
  double finest = std::numeric_limits<double>::infinity();
  for (const angiogram::ConeBeamFrame& frame : frames)
    finest = std::min(finest, pixel_at_isocentre(frame));
  return finest;
}

angiogram::ConeBeamFrame shifted(angiogram::ConeBeamFrame frame, const Vec3& by) {
  frame.source += by;
  frame.first_pixel += by;
  return frame;
}

LineNear ViewLookup::at(const Vec3& place) const {
  const angiogram::SeenPoint seen = view_.see(place);
  const int c = int(std::lround(seen.column)), r = int(std::lround(seen.row));
  LineNear near;
  if (!(seen.depth > 0.0) || c < 0 || c >= picture_.lines.columns || r < 0 ||
      r >= picture_.lines.rows)
    return near;
  near.is_seen = true;
  const std::size_t i = std::size_t(r) * std::size_t(picture_.lines.columns) + std::size_t(c);
  near.pixel = picture_.nearest[i];
  if (near.pixel < 0) return near;
  const double line_column = near.pixel % picture_.lines.columns,
               line_row = near.pixel / picture_.lines.columns;
  near.distance_mm =
      pixel_mm(seen.depth) * std::hypot(seen.column - line_column, seen.row - line_row);
  near.radius_mm = pixel_mm(seen.depth) * double(picture_.lines.radius[std::size_t(near.pixel)]);
  return near;
}

}  // namespace angio::reconstruction::detail
