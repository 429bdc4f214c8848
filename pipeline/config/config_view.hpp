#pragma once

#include <fmt/format.h>

#include <functional>
#include <string>
#include <type_traits>
#include <utility>

#include "pipeline/config/config.hpp"

namespace angio::pipeline {

/// Is a field a part of an object, or all of it?
template <class Part>
bool lies_in(const Part& part, const void* field) {
  const auto* first = static_cast<const char*>(static_cast<const void*>(&part));
  const auto* at = static_cast<const char*>(field);
  return !std::less<>{}(at, first) && std::less<>{}(at, first + sizeof(Part));
}

/// The parts of the configuration that a stage may see. A part that is not named here cannot be
/// read: get() does not compile. The same names make text(), which is the stage's key, so nothing
/// can be read that the key does not hold.
///
/// @tparam kParts  members of Config, or functions that return a reference into one
template <auto... kParts>
class ConfigView {
 public:
  explicit ConfigView(Config config) : config_(std::move(config)) {}

  template <auto kPart>
  static constexpr bool kHolds =
      (std::is_same_v<std::integral_constant<decltype(kPart), kPart>,
                      std::integral_constant<decltype(kParts), kParts>> ||
       ...);

  template <auto kPart>
  requires kHolds<kPart>
  [[nodiscard]] const auto& get() const { return std::invoke(kPart, config_); }

  /// Every setting of these parts, one a line.
  [[nodiscard]] std::string text() const {
    Config copy = config_;
    std::string lines;
    for (const Setting& setting : settings(copy))
      if ((lies_in(std::invoke(kParts, std::as_const(copy)), setting.field) || ...))
        lines += fmt::format("{} = {}\n", setting.key, setting.get());
    return lines;
  }

 private:
  Config config_;
};

}  // namespace angio::pipeline
