#include "formats/detail/header_text.hpp"

#include <array>
#include <cctype>
#include <string>
#include <utility>

#include "core/text.hpp"

namespace angio::formats::detail {
namespace {

bool is_letter(char letter) { return std::isalpha(static_cast<unsigned char>(letter)) != 0; }

/// The word after a key, past spaces and "=" or ":"; empty if neither follows.
std::string_view value_of(std::string_view text, std::size_t after_key) {
  std::size_t at = after_key;
  bool assigned = false;
  while (at < text.size() && (text[at] == ' ' || text[at] == '=' || text[at] == ':'))
    assigned |= text[at++] != ' ';
  if (!assigned) return {};
  std::size_t end = at;
  while (end < text.size() && is_letter(text[end])) ++end;
  return text.substr(at, end - at);
}

}  // namespace

bool says_ras(std::string_view header) {
  return header.find("SPACE=RAS") != std::string_view::npos;
}

std::optional<LengthUnit> unit_of_name(std::string_view name) {
  const std::string word = lower_case(std::string(name));
  constexpr std::array<std::pair<std::string_view, LengthUnit>, 12> kNames{
      {{"mm", LengthUnit::mm},
       {"millimeter", LengthUnit::mm},
       {"millimetre", LengthUnit::mm},
       {"cm", LengthUnit::cm},
       {"centimeter", LengthUnit::cm},
       {"centimetre", LengthUnit::cm},
       {"m", LengthUnit::m},
       {"meter", LengthUnit::m},
       {"metre", LengthUnit::m},
       {"in", LengthUnit::inch},
       {"inch", LengthUnit::inch},
       {"inches", LengthUnit::inch}}};
  for (const auto& [known, unit] : kNames)
    if (word == known || word == std::string(known) + "s") return unit;
  return std::nullopt;
}

std::optional<LengthUnit> stated_unit(std::string_view header) {
  const std::string text = lower_case(std::string(header));
  for (std::size_t at = text.find("unit"); at != std::string::npos;
       at = text.find("unit", at + 4)) {
    if (at > 0 && is_letter(text[at - 1])) continue;  // "community"
    const std::size_t end = at + (text.compare(at, 5, "units") == 0 ? 5 : 4);
    if (const auto unit = unit_of_name(value_of(text, end))) return unit;
  }
  if (text.find("space=lps") != std::string::npos || text.find("space=ras") != std::string::npos)
    return LengthUnit::mm;
  return std::nullopt;
}

}  // namespace angio::formats::detail
