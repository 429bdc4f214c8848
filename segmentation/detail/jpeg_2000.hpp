#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace angio::segmentation::detail {

/// Decodes one grey JPEG 2000 frame with OpenJPEG, its numbers as the bits they are stored in.
///
/// @param stream  a raw code stream (J2K) or a JP2 file
/// @param out     shape [rows, columns]
/// @return why it cannot be decoded, or nothing
std::string decode_jpeg_2000(const std::vector<std::uint8_t>& stream, int columns, int rows,
                             std::uint16_t* out);

}  // namespace angio::segmentation::detail
