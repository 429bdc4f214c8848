#pragma once

#include <cstddef>

namespace angio::reconstruction::detail {

/// Of a picture, its pixels row after row.
struct PictureSize {
  int columns = 0, rows = 0;
  [[nodiscard]] std::size_t count() const { return std::size_t(columns) * std::size_t(rows); }
  [[nodiscard]] std::size_t at(int column, int row) const {
    return std::size_t(row) * std::size_t(columns) + std::size_t(column);
  }
  [[nodiscard]] bool holds(int column, int row) const {
    return column >= 0 && column < columns && row >= 0 && row < rows;
  }
};

}  // namespace angio::reconstruction::detail
