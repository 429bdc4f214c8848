#pragma once

#include <cstring>
#include <string>

namespace angio::formats::detail {

/// Adds the bytes of a number, as this machine orders them (little-endian), to `bytes`.
template <class Number>
void append_number(std::string& bytes, Number number) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &number, sizeof(Number));
  bytes.append(raw, sizeof(Number));
}

}  // namespace angio::formats::detail
