#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace angio::viewer::detail {

using Rgb = std::array<std::uint8_t, 3>;

/// A colour picture, rows from the top.
struct Picture {
  int width = 0;                  ///< [pixel]
  int height = 0;                 ///< [pixel]
  std::vector<std::uint8_t> rgb;  ///< shape [height, width, 3]
};

/// The mean of every factor x factor block: renders drawn larger become smooth.
Picture shrink(const Picture& picture, int factor);

/// White paper.
Picture blank_picture(int width, int height);

/// Copies a picture onto another, its upper left corner at (left, top); it must fit.
void paste(const Picture& picture, int left, int top, Picture& onto);

/// As VTK lays pictures out, from the lowest row up. @param rgb  width x height x 3
void copy_upside_down(const Picture& picture, std::uint8_t* rgb);

/// A whole PNG file; no time stamp, so the same picture gives the same bytes.
std::string png_bytes(const Picture& picture);

}  // namespace angio::viewer::detail
