#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <array>
#include <cmath>
#include <sstream>

#include "core/error.hpp"
#include "pipeline/config/config.hpp"

/// How each kind of field of the configuration stands in TOML; for settings.cpp alone.
namespace angio::pipeline {

[[noreturn]] inline void refuse_value(const std::string& key, const std::string& value,
                                      const char* expected) {
  throw OptionError(
      fmt::format("{} = {} cannot be used (expected {}). See `angio run --print-config`", key,
                  value, expected));
}

inline double number_of(const std::string& key, const toml::node& node) {
  const auto value = node.value<double>();
  if (!value || !std::isfinite(*value)) {
    std::ostringstream text;
    text << toml::node_view<const toml::node>(node);
    refuse_value(key, text.str(), "a number");
  }
  return *value;
}

inline Vec3 point_of(const std::string& key, const toml::node& node) {
  const toml::array* array = node.as_array();
  if (!array || array->size() != 3) refuse_value(key, "this value", "a point [x, y, z] in LPS mm");
  return {number_of(key, (*array)[0]), number_of(key, (*array)[1]), number_of(key, (*array)[2])};
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
  if (!node.is_boolean()) refuse_value(key, "this value", "true or false");
  field = node.as_boolean()->get();
}
inline void read_field(const std::string& key, const toml::node& node, std::string& field) {
  if (!node.is_string()) refuse_value(key, "this value", "a text");
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
  const Vec3 values = point_of(key, node);
  field = {values.x, values.y, values.z};
}
inline void read_field(const std::string& key, const toml::node& node,
                       std::optional<segmentation::LpsBox>& field) {
  if (node.is_string() && node.as_string()->get() == "auto") return field.reset();
  const toml::array* array = node.as_array();
  if (!array || array->size() != 2)
    refuse_value(key, "this value", "two corners [[x, y, z], [x, y, z]] in LPS mm, or \"auto\"");
  field = {point_of(key, (*array)[0]), point_of(key, (*array)[1])};
}
inline void read_field(const std::string& key, const toml::node& node, std::vector<double>& field) {
  const toml::array* array = node.as_array();
  if (!array) refuse_value(key, "this value", "a list of numbers [1, 2, ...]");
  field.clear();
  for (const toml::node& element : *array) field.push_back(number_of(key, element));
}
inline void read_field(const std::string& key, const toml::node& node, std::vector<Vec3>& field) {
  const toml::array* array = node.as_array();
  if (!array) refuse_value(key, "this value", "a list of points [[x, y, z], ...] in LPS mm");
  field.clear();
  for (const toml::node& element : *array) field.push_back(point_of(key, element));
}

inline void read_field(const std::string& key, const toml::node& node,
                       std::vector<simulation::ChartPoint>& field) {
  constexpr const char* kExpected = "a list of points [[atm, mm], ...]";
  const toml::array* array = node.as_array();
  if (!array) refuse_value(key, "this value", kExpected);
  field.clear();
  for (const toml::node& element : *array) {
    const toml::array* point = element.as_array();
    if (!point || point->size() != 2) refuse_value(key, "this value", kExpected);
    field.push_back({number_of(key, (*point)[0]), number_of(key, (*point)[1])});
  }
}

inline constexpr const char* kMembraneModels[] = {"automatic", "plain", "relaxed"};

/// One of an enumeration's names.
template <class Enum, std::size_t kCount>
void read_name(const std::string& key, const toml::node& node, const char* const (&names)[kCount],
               Enum& field) {
  const std::string text = node.value_or(std::string());
  std::string expected;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (text == names[i]) {
      field = Enum(i);
      return;
    }
    expected += (i == 0 ? "" : i + 1 == kCount ? " or " : ", ") + std::string(names[i]);
  }
  refuse_value(key, text, expected.c_str());
}
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::MembraneModel& field) {
  read_name(key, node, kMembraneModels, field);
}
inline constexpr const char* kWallShapes[] = {"linear", "quadratic"};
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::WallShape& field) {
  read_name(key, node, kWallShapes, field);
}
inline constexpr const char* kWallModels[] = {"shape_matching", "layered"};
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::WallModel& field) {
  read_name(key, node, kWallModels, field);
}
inline constexpr const char* kPlaques[] = {"fibrous", "hypocellular", "calcified"};
inline void read_field(const std::string& key, const toml::node& node, simulation::Plaque& field) {
  read_name(key, node, kPlaques, field);
}
inline constexpr const char* kContactModels[] = {"barrier", "paper"};
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::ContactModel& field) {
  read_name(key, node, kContactModels, field);
}
inline constexpr const char* kGasModels[] = {"enclosed", "per_tet"};
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::GasModel& field) {
  read_name(key, node, kGasModels, field);
}
inline constexpr const char* kGuidewires[] = {"none", "rod"};
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::GuidewireModel& field) {
  read_name(key, node, kGuidewires, field);
}
inline constexpr const char* kGuidewireRests[] = {"straight", "placed"};
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::GuidewireRest& field) {
  read_name(key, node, kGuidewireRests, field);
}
inline constexpr const char* kGuidewireTips[] = {"held", "free"};
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::GuidewireTip& field) {
  read_name(key, node, kGuidewireTips, field);
}
inline constexpr const char* kControls[] = {"gas", "pressure", "volume"};
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::InflationControl& field) {
  read_name(key, node, kControls, field);
}
inline constexpr const char* kClothSolvers[] = {"newton", "vbd"};
inline void read_field(const std::string& key, const toml::node& node,
                       simulation::ClothSolver& field) {
  read_name(key, node, kClothSolvers, field);
}
inline constexpr const char* kAngleNames[] = {"from-base", "cumulative"};
inline void read_field(const std::string& key, const toml::node& node,
                       segmentation::AngleIncrements& field) {
  read_name(key, node, kAngleNames, field);
}
inline void read_field(const std::string& key, const toml::node& node,
                       std::optional<LengthUnit>& field) {
  if (node.is_string() && node.as_string()->get() == "auto") return field.reset();
  LengthUnit unit = LengthUnit::mm;
  read_name(key, node, kLengthUnitNames, unit);
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
inline std::string write_field(simulation::MembraneModel field) {
  return quoted(kMembraneModels[int(field)]);
}
inline std::string write_field(simulation::ContactModel field) {
  return quoted(kContactModels[int(field)]);
}
inline std::string write_field(simulation::GasModel field) {
  return quoted(kGasModels[int(field)]);
}
inline std::string write_field(simulation::GuidewireModel field) {
  return quoted(kGuidewires[int(field)]);
}
inline std::string write_field(simulation::GuidewireRest field) {
  return quoted(kGuidewireRests[int(field)]);
}
inline std::string write_field(simulation::GuidewireTip field) {
  return quoted(kGuidewireTips[int(field)]);
}
inline std::string write_field(simulation::WallModel field) {
  return quoted(kWallModels[int(field)]);
}
inline std::string write_field(simulation::Plaque field) { return quoted(kPlaques[int(field)]); }
inline std::string write_field(simulation::WallShape field) {
  return quoted(kWallShapes[int(field)]);
}
inline std::string write_field(simulation::InflationControl field) {
  return quoted(kControls[int(field)]);
}
inline std::string write_field(simulation::ClothSolver field) {
  return quoted(kClothSolvers[int(field)]);
}
inline std::string write_field(const std::optional<LengthUnit>& field) {
  return quoted(field ? kLengthUnitNames[int(*field)] : "auto");
}
inline std::string write_field(const simulation::ChartPoint& field) {
  return fmt::format("[{}, {}]", write_field(field.pressure_atm), write_field(field.diameter_mm));
}
inline std::string write_field(const Vec3& field) {
  return fmt::format("[{}, {}, {}]", write_field(field.x), write_field(field.y),
                     write_field(field.z));
}
inline std::string write_field(segmentation::AngleIncrements field) {
  return quoted(kAngleNames[int(field)]);
}
inline std::string write_field(const std::array<double, 3>& field) {
  return write_field(Vec3{field[0], field[1], field[2]});
}
inline std::string write_field(const segmentation::LpsBox& field) {
  return fmt::format("[{}, {}]", write_field(field.low), write_field(field.high));
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
