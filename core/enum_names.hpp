#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

/// How users write the values of an enumeration. A table stands once, beside the enumeration:
///
///     template <>
///     struct EnumNames<simulation::WallShape> {
///       static constexpr std::array kNames{"linear", "quadratic"};
///     };
///
/// in the order of its values, which count from 0.
namespace angio {

template <class Enum>
struct EnumNames;

template <class Enum>
concept NamedEnum = requires {
  EnumNames<Enum>::kNames.size();
};

template <NamedEnum Enum>
constexpr const char* enum_name(Enum value) {
  return EnumNames<Enum>::kNames[std::size_t(value)];
}

template <NamedEnum Enum>
constexpr std::optional<Enum> enum_of_name(std::string_view name) {
  for (std::size_t i = 0; i < EnumNames<Enum>::kNames.size(); ++i)
    if (name == EnumNames<Enum>::kNames[i]) return Enum(i);
  return std::nullopt;
}

/// All names in words: "gas, pressure or volume".
template <NamedEnum Enum>
std::string list_enum_names() {
  const auto& names = EnumNames<Enum>::kNames;
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i)
    list += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + std::string(names[i]);
  return list;
}

}  // namespace angio
