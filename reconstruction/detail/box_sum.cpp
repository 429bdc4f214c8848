#include "reconstruction/detail/box_sum.hpp"

#include <algorithm>
#include <cstddef>

namespace angio::reconstruction::detail {
namespace {

/// Sums over 2 half + 1 pixels of each row.
void box_sum_rows(std::vector<double>& values, int columns, int rows, int half) {
  std::vector<double> sums(std::size_t(columns) + 1);
  for (int r = 0; r < rows; ++r) {
    double* row = values.data() + std::size_t(r) * std::size_t(columns);
    sums[0] = 0.0;
    for (int c = 0; c < columns; ++c) sums[std::size_t(c) + 1] = sums[std::size_t(c)] + row[c];
    for (int c = 0; c < columns; ++c)
      row[c] = sums[std::size_t(std::min(c + half + 1, columns))] -
               sums[std::size_t(std::max(c - half, 0))];
  }
}

}  // namespace

void box_sum(std::vector<double>& values, int columns, int rows, int half,
             std::vector<double>& above) {
  box_sum_rows(values, columns, rows, half);
  const std::size_t width = std::size_t(columns);
  above.resize((std::size_t(rows) + 1) * width);
  std::fill_n(above.begin(), width, 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) above[i + width] = above[i] + values[i];
  for (int r = 0; r < rows; ++r) {
    const double* last = above.data() + std::size_t(std::min(r + half + 1, rows)) * width;
    const double* first = above.data() + std::size_t(std::max(r - half, 0)) * width;
    double* row = values.data() + std::size_t(r) * width;
    for (std::size_t c = 0; c < width; ++c) row[c] = last[c] - first[c];
  }
}

}  // namespace angio::reconstruction::detail
