#include "pipeline/stages/standing_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/error.hpp"
#include "reconstruction/views.hpp"

namespace angio::pipeline {
namespace {

/// Blocks of pixels as one.
StandingPicture coarser(const StandingPicture& picture, int block) {
  if (block == 1) return picture;
  const double middle = 0.5 * (block - 1);
  StandingPicture small;
  small.frame = {picture.frame.source,
                 picture.frame.place(middle, middle),
                 double(block) * picture.frame.column_step,
                 double(block) * picture.frame.row_step,
                 picture.frame.columns / block,
                 picture.frame.rows / block};
  for (int row = 0; row < small.frame.rows; ++row)
    for (int column = 0; column < small.frame.columns; ++column) {
      double sum = 0.0;
      char is_covered = 0;
      for (int y = row * block; y < (row + 1) * block; ++y)
        for (int x = column * block; x < (column + 1) * block; ++x) {
          const std::size_t i =
              std::size_t(y) * std::size_t(picture.frame.columns) + std::size_t(x);
          sum += double(picture.pixels[i]);
          if (!picture.covered.empty() && picture.covered[i] != 0) is_covered = 1;
        }
      small.pixels.push_back(float(sum / (block * block)));
      if (!picture.covered.empty()) small.covered.push_back(is_covered);
    }
  return small;
}

/// Widened by what its border has.
StandingPicture of_size(const StandingPicture& picture, int columns, int rows) {
  const int left = (picture.frame.columns - columns) / 2, top = (picture.frame.rows - rows) / 2;
  StandingPicture sized{picture.frame, {}, {}};
  sized.frame.first_pixel = picture.frame.place(left, top);
  sized.frame.columns = columns;
  sized.frame.rows = rows;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const int y = std::clamp(row + top, 0, picture.frame.rows - 1),
                x = std::clamp(column + left, 0, picture.frame.columns - 1);
      const std::size_t i = std::size_t(y) * std::size_t(picture.frame.columns) + std::size_t(x);
      sized.pixels.push_back(picture.pixels[i]);
      const bool is_border = y != row + top || x != column + left;
      sized.covered.push_back(
          is_border || (!picture.covered.empty() && picture.covered[i] != 0) ? 1 : 0);
    }
  return sized;
}

}  // namespace

void even_out(std::vector<StandingPicture>& pictures) {
  constexpr int kLongestSide = 1024, kShortestSide = 32;
  double coarsest = 0.0;
  for (const StandingPicture& picture : pictures)
    coarsest = std::max(coarsest, norm(picture.frame.column_step));
  int columns = 0, rows = 0;
  for (StandingPicture& picture : pictures) {
    const double pixel = norm(picture.frame.column_step);
    const int block = std::max(1, int(std::lround(coarsest / pixel)));
    const int longest = std::max(picture.frame.columns, picture.frame.rows);
    picture = coarser(picture, std::max(block, (longest + kLongestSide - 1) / kLongestSide));
    const reconstruction::OpenField open =
        reconstruction::around_open(picture.covered, picture.frame.columns, picture.frame.rows);
    if (std::min(open.last_column - open.first_column, open.last_row - open.first_row) + 1 <
        kShortestSide)
      throw InputError(
          fmt::format("a view is too small: its picture, or what a shutter leaves of it, has less "
                      "than {} pixels of {:g} mm (its own are of {:g} mm, the coarsest view's of "
                      "{:g} mm on their detectors). Give views of like resolution",
                      kShortestSide, norm(picture.frame.column_step), pixel, coarsest));
    columns = std::max(columns, picture.frame.columns);
    rows = std::max(rows, picture.frame.rows);
  }
  for (StandingPicture& picture : pictures)
    if (picture.frame.columns != columns || picture.frame.rows != rows)
      picture = of_size(picture, columns, rows);
}

}  // namespace angio::pipeline
