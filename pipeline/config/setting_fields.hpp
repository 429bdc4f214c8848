#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <array>
#include <cmath>
#include <sstream>

#include "core/enum_names.hpp"
#include "core/error.hpp"
#include "meshing/option_names.hpp"
#include "pipeline/config/config.hpp"
#include "segmentation/option_names.hpp"
#include "simulation/option_names.hpp"

namespace angio {

template <>
struct EnumNames<LengthUnit> {
  static constexpr auto kNames = std::to_array(kLengthUnitNames);
};

template <>
struct EnumNames<reconstruction::Method> {
  static constexpr auto kNames = std::to_array(reconstruction::kMethodNames);
};
template <>
struct EnumNames<reconstruction::Gating> {
  static constexpr auto kNames = std::to_array(reconstruction::kGatingNames);
};
template <>
struct EnumNames<reconstruction::FilterWindow> {
  static constexpr auto kNames = std::to_array(reconstruction::kFilterWindowNames);
};

template <>
struct EnumNames<pipeline::FlowVessel> {
  static constexpr std::array kNames{"auto", "coronary", "other"};
};

}  // namespace angio

/// How each kind of field of the configuration stands in TOML; for settings.cpp alone.
namespace angio::pipeline {

[[noreturn]] inline void refuse_value(const std::string& key, const std::string& value,
                                      const char* expected) {
  throw OptionError(
      fmt::format("{} = {} cannot be used (expected {}). See `angio run --print-config`", key,
                  value, expected));
}

[[noreturn]] inline void refuse_value(const std::string& key, const toml::node& node,
                                      const char* expected) {
  std::ostringstream text;
  text << toml::node_view<const toml::node>(node);
  refuse_value(key, text.str(), expected);
}

inline double number_of(const std::string& key, const toml::node& node) {
  const auto value = node.value<double>();
  if (!value || !std::isfinite(*value)) refuse_value(key, node, "a number");
  return *value;
}

/// Three numbers.
inline std::array<double, 3> triple_of(const std::string& key, const toml::node& node,
                                       const char* expected) {
  const toml::array* array = node.as_array();
  if (!array || array->size() != 3) refuse_value(key, node, expected);
  return {number_of(key, (*array)[0]), number_of(key, (*array)[1]), number_of(key, (*array)[2])};
}

inline Vec3 point_of(const std::string& key, const toml::node& node) {
  const auto [x, y, z] = triple_of(key, node, "a point [x, y, z] in LPS mm");
  return {x, y, z};
}

inline void read_field(const std::string& key, const toml::node& node, double& field) {
  field = number_of(key, node);
}
inline void read_field(const std::string& key, const toml::node& node, int& field) {
  const double number = number_of(key, node);
  if (number != std::floor(number) || std::abs(number) > 1e9)
    refuse_value(key, fmt::format("{}", number), "a whole number");
  field = int(number);
}
inline void read_field(const std::string& key, const toml::node& node, bool& field) {
  if (!node.is_boolean()) refuse_value(key, node, "true or false");
  field = node.as_boolean()->get();
}
inline void read_field(const std::string& key, const toml::node& node, std::string& field) {
  if (!node.is_string()) refuse_value(key, node, "a text");
  field = node.as_string()->get();
}
inline void read_field(const std::string& key, const toml::node& node,
                       std::optional<double>& field) {
  if (node.is_string() && node.as_string()->get() == "auto")
    field.reset();
  else
    field = number_of(key, node);
}
inline void read_field(const std::string& key, const toml::node& node, std::optional<Vec3>& field) {
  if (node.is_string() && node.as_string()->get() == "auto")
    field.reset();
  else
    field = point_of(key, node);
}
inline void read_field(const std::string& key, const toml::node& node,
                       std::array<double, 3>& field) {
  field = triple_of(key, node, "three numbers [i, j, k]");
}
inline void read_field(const std::string& key, const toml::node& node,
                       std::optional<segmentation::LpsBox>& field) {
  if (node.is_string() && node.as_string()->get() == "auto") return field.reset();
  const toml::array* array = node.as_array();
  if (!array || array->size() != 2)
    refuse_value(key, node, "two corners [[x, y, z], [x, y, z]] in LPS mm, or \"auto\"");
  field = {point_of(key, (*array)[0]), point_of(key, (*array)[1])};
}
inline void read_field(const std::string& key, const toml::node& node, std::vector<double>& field) {
  const toml::array* array = node.as_array();
  if (!array) refuse_value(key, node, "a list of numbers [1, 2, ...]");
  field.clear();
  for (const toml::node& element : *array) field.push_back(number_of(key, element));
}
inline void read_field(const std::string& key, const toml::node& node, std::vector<Vec3>& field) {
  const toml::array* array = node.as_array();
  if (!array) refuse_value(key, node, "a list of points [[x, y, z], ...] in LPS mm");
  field.clear();
  for (const toml::node& element : *array) field.push_back(point_of(key, element));
}

inline void read_field(const std::string& key, const toml::node& node,
                       std::vector<simulation::ChartPoint>& field) {
  constexpr const char* kExpected = "a list of points [[atm, mm], ...]";
  const toml::array* array = node.as_array();
  if (!array) refuse_value(key, node, kExpected);
  field.clear();
  for (const toml::node& element : *array) {
    const toml::array* point = element.as_array();
    if (!point || point->size() != 2) refuse_value(key, node, kExpected);
    field.push_back({number_of(key, (*point)[0]), number_of(key, (*point)[1])});
  }
}

/// One of an enumeration's names.
template <NamedEnum Enum>
void read_field(const std::string& key, const toml::node& node, Enum& field) {
  const std::string text = node.value_or(std::string());
  const std::optional<Enum> value = enum_of_name<Enum>(text);
  if (!value) refuse_value(key, text, list_enum_names<Enum>().c_str());
  field = *value;
}
inline void read_field(const std::string& key, const toml::node& node,
                       std::optional<LengthUnit>& field) {
  if (node.is_string() && node.as_string()->get() == "auto") return field.reset();
  LengthUnit unit = LengthUnit::mm;
  read_field(key, node, unit);
  field = unit;
}

inline std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}
inline std::string write_field(double field) {
  const std::string text = fmt::format("{}", field);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}
inline std::string write_field(int field) { return fmt::format("{}", field); }
inline std::string write_field(bool field) { return field ? "true" : "false"; }
inline std::string write_field(const std::string& field) { return quoted(field); }
template <NamedEnum Enum>
std::string write_field(Enum field) {
  return quoted(enum_name(field));
}
inline std::string write_field(const simulation::ChartPoint& field) {
  return fmt::format("[{}, {}]", write_field(field.pressure_atm), write_field(field.diameter_mm));
}
inline std::string write_field(const Vec3& field) {
  return fmt::format("[{}, {}, {}]", write_field(field.x), write_field(field.y),
                     write_field(field.z));
}
inline std::string write_field(const std::array<double, 3>& field) {
  return write_field(Vec3{field[0], field[1], field[2]});
}
inline std::string write_field(const segmentation::LpsBox& field) {
  return fmt::format("[{}, {}]", write_field(field.low), write_field(field.high));
}
inline std::string write_field(const std::optional<LengthUnit>& field) {
  return quoted(field ? enum_name(*field) : "auto");
}
template <class Value>
std::string write_field(const std::optional<Value>& field) {
  return field ? write_field(*field) : "\"auto\"";
}
template <class Value>
std::string write_field(const std::vector<Value>& field) {
  std::string text;
  for (const Value& point : field) text += (text.empty() ? "" : ", ") + write_field(point);
  return "[" + text + "]";
}

/// A bare word is a text: `--set balloon.material=pa12` needs no quotes.
inline toml::table parse_value(const std::string& key, const std::string& value) {
  try {
    return toml::parse("value = " + value);
  } catch (const toml::parse_error&) {
  }
  try {
    return toml::parse("value = " + quoted(value));
  } catch (const toml::parse_error&) {
    refuse_value(key, value, "a TOML value");
  }
}

template <class Field>
Setting make_setting(std::string key, Field& field, std::string help) {
  Setting setting{key, &field, std::move(help), nullptr, nullptr};
  setting.get = [&field] { return write_field(field); };
  setting.set = [&field, key](const std::string& value) {
    const toml::table table = parse_value(key, value);
    read_field(key, *table.get("value"), field);
  };
  return setting;
}

}  // namespace angio::pipeline
