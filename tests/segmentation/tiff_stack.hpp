#pragma once

#include <cstdint>
#include <string>

/// TIFF (Adobe, TIFF 6.0, 1992), little endian, pages of 16 bit, one strip each.
namespace angio::segmentation::tests {

/// @return the file's bytes; pixel (column, row) of page p is p * 1000 + row * 10 + column
inline std::string tiff_stack(std::uint32_t columns, std::uint32_t rows, std::uint32_t pages) {
  std::string bytes;
  const auto put = [&](std::uint32_t value, int count) {
    for (int n = 0; n < count; ++n) bytes += char((value >> (8 * n)) & 0xFFU);
  };
  constexpr std::uint32_t kHead = 8, kEntries = 9, kFolder = 2 + kEntries * 12 + 4;
  bytes += "II";
  put(42, 2);
  put(kHead, 4);
  const std::uint32_t strip = columns * rows * 2;
  for (std::uint32_t page = 0; page < pages; ++page) {
    const auto at = std::uint32_t(bytes.size());
    const auto entry = [&](std::uint32_t tag, std::uint32_t type, std::uint32_t value) {
      put(tag, 2);
      put(type, 2);
      put(1, 4);
      put(value, 4);
    };
    put(kEntries, 2);
    entry(256, 4, columns);
    entry(257, 4, rows);
    entry(258, 3, 16);            // bits
    entry(259, 3, 1);             // not compressed
    entry(262, 3, 1);             // black is zero
    entry(273, 4, at + kFolder);  // the strip
    entry(277, 3, 1);             // values a pixel
    entry(278, 4, rows);
    entry(279, 4, strip);
    put(page + 1 < pages ? at + kFolder + strip : 0, 4);
    for (std::uint32_t row = 0; row < rows; ++row)
      for (std::uint32_t column = 0; column < columns; ++column)
        put(page * 1000 + row * 10 + column, 2);
  }
  return bytes;
}

}  // namespace angio::segmentation::tests
