#include "pipeline/cli/sweep.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "formats/csv.hpp"
#include "formats/tokens.hpp"
#include "viewer/sweep_plot.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

/// What a folder's name may hold of a value.
std::string as_name(std::string text) {
  for (char& c : text)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
  return text;
}

std::string name_of(const SweepAxis& axis, const std::string& value) {
  return as_name(axis.key.substr(axis.key.find('.') + 1) + "-" + value);
}

formats::CsvRow header_of(const std::vector<SweepAxis>& axes) {
  formats::CsvRow header{"variant"};
  for (const SweepAxis& axis : axes) header.push_back(axis.key);
  header.emplace_back("status");
  for (const VariantMeasure& measure : variant_measures()) header.emplace_back(measure.column);
  header.emplace_back("reason");
  return header;
}

formats::CsvRow cells_of(const VariantRow& row, std::size_t axis_count) {
  formats::CsvRow cells{row.variant.name};
  for (std::size_t a = 0; a < axis_count; ++a) cells.push_back(value_of(row.variant, a));
  cells.push_back(row.status);
  for (const double value : row.measures) cells.push_back(cell_of(value));
  cells.push_back(row.reason);
  return cells;
}

json json_of(const VariantRow& row, const std::vector<SweepAxis>& axes) {
  json values = json::object();
  for (std::size_t a = 0; a < axes.size(); ++a) values[axes[a].key] = value_of(row.variant, a);
  return {{"variant", row.variant.name},
          {"values", values},
          {"status", row.status},
          {"reason", row.reason.empty() ? json() : json(row.reason)},
          {"measures", measures_json(row)}};
}

/// What a sweep is for comes first.
constexpr const char* kChartOrder[] = {"mld_after_mm",
                                       "acute_gain_mm",
                                       "recoil_percent",
                                       "residual_stenosis_percent",
                                       "over_strength_percent",
                                       "over_strength_mm3",
                                       "balloon_to_artery_ratio",
                                       "ffr_after",
                                       "mld_before_mm"};

/// A key as people say it: "balloon.length_mm" is the balloon length, in mm.
struct SettingName {
  std::string words, unit;
};

SettingName name_setting(const std::string& key) {
  struct Unit {
    std::string_view ending, text;
  };
  constexpr Unit kUnits[] = {{"_kpa_per_mm", "kPa/mm"},
                             {"_per_s", "1/s"},
                             {"_g_mm3", "g/mm³"},
                             {"_kg_m3", "kg/m³"},
                             {"_ml_min", "ml/min"},
                             {"_m_s", "m/s"},
                             {"_mpa_s", "mPa s"},
                             {"_mmhg", "mmHg"},
                             {"_mm3", "mm³"},
                             {"_mm", "mm"},
                             {"_atm", "atm"},
                             {"_kpa", "kPa"},
                             {"_mpa", "MPa"},
                             {"_gib", "GiB"},
                             {"_percent", "%"},
                             {"_degrees", "°"},
                             {"_s", "s"}};
  SettingName name{key, ""};
  for (const Unit& unit : kUnits)
    if (key.ends_with(unit.ending)) {
      name = {key.substr(0, key.size() - unit.ending.size()), std::string(unit.text)};
      break;
    }
  for (char& c : name.words)
    if (c == '.' || c == '_') c = ' ';
  return name;
}

/// "balloon length 10 mm".
std::string words_of(const SweepAxis& axis, const std::string& value) {
  const SettingName name = name_setting(axis.key);
  return name.words + " " + value + (name.unit.empty() ? "" : " " + name.unit);
}

/// Each measure against the first setting, a curve for each choice of the others.
std::vector<viewer::SweepPanel> panels_of(const std::vector<SweepAxis>& axes,
                                          const std::vector<VariantRow>& rows) {
  std::vector<double> x;
  std::vector<std::string> labels;
  for (const VariantRow& row : rows) {
    x.push_back(formats::parse_number<double>(value_of(row.variant, 0)).value_or(kNotMeasured));
    std::string& others = labels.emplace_back();
    for (std::size_t a = 1; a < axes.size(); ++a)
      others += (others.empty() ? "" : ", ") + words_of(axes[a], value_of(row.variant, a));
  }
  return panels_of(rows, x, labels);
}

/// The one value that all results share, as it stands in the table; nothing where they differ or
/// are fewer than two.
std::optional<std::string> shared_value(const std::vector<VariantRow>& rows, std::size_t measure) {
  std::set<std::string> values;
  std::size_t count = 0;
  for (const VariantRow& row : rows)
    if (std::isfinite(row.measures[measure])) {
      values.insert(cell_of(row.measures[measure]));
      ++count;
    }
  return count > 1 && values.size() == 1 ? std::optional(*values.begin()) : std::nullopt;
}

/// Charts of what the settings change; a line says what they do not.
void draw_sweep(const fs::path& file, const std::vector<SweepAxis>& axes,
                const std::vector<VariantRow>& rows) {
  std::vector<viewer::SweepPanel> all = panels_of(axes, rows), changed, same;
  std::vector<std::string> notes;
  for (const std::string_view column : kChartOrder)
    for (std::size_t m = 0; m < all.size(); ++m) {
      if (variant_measures()[m].column != column) continue;
      const auto value = shared_value(rows, m);
      if (value) notes.push_back("the same in all variants: " + all[m].measure + ", " + *value);
      (value ? same : changed).push_back(std::move(all[m]));
    }
  const SettingName name = name_setting(axes[0].key);
  const std::string setting = name.words + (name.unit.empty() ? "" : " [" + name.unit + "]");
  // Where nothing changes at all that is what is drawn.
  if (!viewer::write_sweep_plot(file, setting, changed, notes))
    viewer::write_sweep_plot(file, setting, same);
}

}  // namespace

SweepAxis parse_axis(const std::string& text) {
  const auto equals = text.find('=');
  SweepAxis axis{text.substr(0, equals), {}};
  if (equals == std::string::npos || axis.key.empty())
    throw Error(ExitCode::usage,
                "\"" + text +
                    "\" is no setting with its values (expected section.key=a,b,c). Separate the "
                    "values by commas");
  std::set<std::string> seen;
  for (std::size_t at = equals + 1; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    axis.values.push_back(text.substr(at, end - at));
    if (axis.values.back().empty() || !seen.insert(axis.values.back()).second)
      throw Error(ExitCode::usage,
                  text + ": a value is empty or there twice (expected section.key=a,b,c)");
    at = end + 1;
  }
  return axis;
}

namespace {

/// Values have keys of their own on the command line, without a --set.
void check_keys(const std::vector<SweepAxis>& axes, Config config) {
  std::vector<std::string> known;
  for (const Setting& setting : settings(config)) known.push_back(setting.key);
  for (const SweepAxis& axis : axes) {
    if (std::find(known.begin(), known.end(), axis.key) != known.end()) continue;
    const std::string guess = guess_name(axis.key, known);
    throw OptionError(
        fmt::format("there is no setting {} to give the values {}{}. `angio run --print-config` "
                    "lists all settings",
                    axis.key, fmt::join(axis.values, ","),
                    guess.empty() ? "" : fmt::format(" (did you mean {}?)", guess)));
  }
}

/// A variant's configuration. @throws OptionError (78) that names the variant's values
void check_variant(const BatchCase& variant, Config config) {
  try {
    for (const std::string& setting : variant.settings) apply_setting(config, setting);
    config.validate();
  } catch (const OptionError& error) {
    throw OptionError(fmt::format("{}: {}", fmt::join(variant.settings, " "), error.what()));
  }
}

}  // namespace

std::vector<BatchCase> make_variants(const std::vector<SweepAxis>& axes, const Config& config) {
  check_keys(axes, config);
  std::vector<BatchCase> variants{{}};
  std::set<std::string> keys;
  for (const SweepAxis& axis : axes) {
    if (!keys.insert(axis.key).second)
      throw OptionError(axis.key + " is given values twice. Write them all once: " + axis.key +
                        "=a,b,c");
    std::vector<BatchCase> more;
    for (const BatchCase& variant : variants)
      for (const std::string& value : axis.values) {
        BatchCase one = variant;
        one.name += (one.name.empty() ? "" : "_") + name_of(axis, value);
        one.settings.push_back(axis.key + "=" + value);
        more.push_back(std::move(one));
      }
    variants = std::move(more);
    if (variants.size() > kMostVariants)
      throw Error(
          ExitCode::usage,
          fmt::format("the sweep has more than {} variants. Give fewer values", kMostVariants));
  }
  std::set<std::string> names;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    check_variant(variants[v], config);
    constexpr std::size_t kLongestName = 90;
    std::string& name = variants[v].name;
    if (name.size() > kLongestName || !names.insert(name).second)
      name = fmt::format("variant-{:03d}", v + 1);
  }
  return variants;
}

void write_sweep(const fs::path& folder, const std::vector<SweepAxis>& axes,
                 const std::vector<VariantRow>& rows) {
  std::vector<formats::CsvRow> table = {header_of(axes)};
  json variants = json::array();
  for (const VariantRow& row : rows) {
    table.push_back(cells_of(row, axes.size()));
    variants.push_back(json_of(row, axes));
  }
  write_text_atomically(folder / "sweep.csv", csv_text(table));
  write_text_atomically(folder / "sweep.json", json{{"variants", variants}}.dump(2) + "\n");
  const auto is_number = [](const std::string& value) {
    return formats::parse_number<double>(value).has_value();
  };
  if (std::all_of(axes[0].values.begin(), axes[0].values.end(), is_number))
    draw_sweep(folder / "sweep.svg", axes, rows);
}

std::string sweep_table(const std::vector<SweepAxis>& axes, const std::vector<VariantRow>& rows) {
  constexpr std::array<std::size_t, 5> kShown = {1, 2, 3, 4, 7};  // of the measures
  std::vector<formats::CsvRow> table(1);
  for (const SweepAxis& axis : axes) table[0].push_back(axis.key);
  table[0].emplace_back("status");
  for (const std::size_t m : kShown) table[0].emplace_back(variant_measures()[m].column);
  for (const VariantRow& row : rows) {
    formats::CsvRow& cells = table.emplace_back();
    for (std::size_t a = 0; a < axes.size(); ++a) cells.push_back(value_of(row.variant, a));
    cells.push_back(row.status);
    for (const std::size_t m : kShown)
      cells.push_back(std::isnan(row.measures[m]) ? "-" : cell_of(row.measures[m]));
  }
  return aligned_text(table);
}

}  // namespace angio::pipeline
