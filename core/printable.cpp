#include "core/printable.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace angio {
namespace {

struct Letter {
  std::uint32_t code = 0;
  std::size_t size = 0;  ///< in bytes; 0: not UTF-8
};

/// The letter at the head of a text (RFC 3629): the shortest form alone, and no half of a pair.
Letter first_letter(std::string_view text) {
  constexpr std::array<std::uint32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};
  const auto head = static_cast<unsigned char>(text.front());
  if (head < 0x80) return {head, 1};
  const std::size_t size = head >= 0xF0 ? 4 : head >= 0xE0 ? 3 : head >= 0xC0 ? 2 : 0;
  if (size == 0 || head > 0xF4 || text.size() < size) return {};
  std::uint32_t code = head & (0xFFU >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xC0U) != 0x80U) return {};
    code = (code << 6U) | (next & 0x3FU);
  }
  const bool is_half = code >= 0xD800 && code <= 0xDFFF;
  return code < kLeast.at(size) || is_half || code > 0x10FFFF ? Letter{} : Letter{code, size};
}

bool commands_a_terminal(std::uint32_t code) {
  const bool turns_writing = (code >= 0x202A && code <= 0x202E) ||
                             (code >= 0x2066 && code <= 0x2069) || code == 0x200E || code == 0x200F;
  const bool breaks_line = code == 0x2028 || code == 0x2029;
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || turns_writing || breaks_line;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const Letter letter = first_letter(text);
    const bool is_shown = letter.size > 0 && !commands_a_terminal(letter.code);
    result += is_shown ? text.substr(0, letter.size) : "?";
    text.remove_prefix(std::max<std::size_t>(letter.size, 1));
  }
  return result;
}

}  // namespace angio
