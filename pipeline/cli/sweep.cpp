#include "pipeline/cli/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "formats/tokens.hpp"
#include "pipeline/case/stage.hpp"
#include "viewer/sweep_plot.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// What a folder's name may hold of a value.
std::string as_name(std::string text) {
  for (char& c : text)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
  return text;
}

std::string name_of(const SweepAxis& axis, const std::string& value) {
  return as_name(axis.key.substr(axis.key.find('.') + 1) + "-" + value);
}

/// A variant's value of an axis.
std::string value_of(const BatchCase& variant, std::size_t axis) {
  const std::string& setting = variant.settings[axis];
  return setting.substr(setting.find('=') + 1);
}

std::string cell_of(double value) { return std::isnan(value) ? "" : fmt::format("{:.4g}", value); }

formats::CsvRow header_of(const std::vector<SweepAxis>& axes) {
  formats::CsvRow header{"variant"};
  for (const SweepAxis& axis : axes) header.push_back(axis.key);
  header.emplace_back("status");
  for (const SweepMeasure& measure : sweep_measures()) header.emplace_back(measure.column);
  header.emplace_back("reason");
  return header;
}

formats::CsvRow cells_of(const SweepRow& row, std::size_t axis_count) {
  formats::CsvRow cells{row.variant.name};
  for (std::size_t a = 0; a < axis_count; ++a) cells.push_back(value_of(row.variant, a));
  cells.push_back(row.status);
  for (const double value : row.measures) cells.push_back(cell_of(value));
  cells.push_back(row.reason);
  return cells;
}

json json_of(const SweepRow& row, const std::vector<SweepAxis>& axes) {
  json values = json::object(), measures = json::object();
  for (std::size_t a = 0; a < axes.size(); ++a) values[axes[a].key] = value_of(row.variant, a);
  for (std::size_t m = 0; m < row.measures.size(); ++m)
    measures[sweep_measures()[m].column] =
        std::isnan(row.measures[m]) ? json() : json(row.measures[m]);
  return {{"variant", row.variant.name},
          {"values", values},
          {"status", row.status},
          {"reason", row.reason.empty() ? json() : json(row.reason)},
          {"measures", measures}};
}

/// Each measure against the first setting, a curve for each choice of the others.
std::vector<viewer::SweepPanel> panels_of(const std::vector<SweepAxis>& axes,
                                          const std::vector<SweepRow>& rows) {
  std::vector<viewer::SweepPanel> panels;
  for (std::size_t m = 0; m < sweep_measures().size(); ++m) {
    viewer::SweepPanel& panel = panels.emplace_back();
    panel.measure = sweep_measures()[m].title;
    for (const SweepRow& row : rows) {
      std::string others;
      for (std::size_t a = 1; a < axes.size(); ++a)
        others += (others.empty() ? "" : ", ") + row.variant.settings[a];
      auto curve = std::find_if(panel.curves.begin(), panel.curves.end(),
                                [&](const auto& c) { return c.label == others; });
      if (curve == panel.curves.end())
        curve = panel.curves.insert(curve, viewer::SweepCurve{others, {}, {}});
      curve->x.push_back(formats::parse_number<double>(value_of(row.variant, 0)).value_or(kNone));
      curve->y.push_back(row.measures[m]);
    }
  }
  return panels;
}

}  // namespace

SweepAxis parse_axis(const std::string& text) {
  const auto equals = text.find('=');
  SweepAxis axis{text.substr(0, equals), {}};
  if (equals == std::string::npos || axis.key.empty())
    throw Error(ExitCode::usage, "\"" + text +
                                     "\" is no setting with values. Write "
                                     "section.key=a,b,c");
  std::set<std::string> seen;
  for (std::size_t at = equals + 1; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    axis.values.push_back(text.substr(at, end - at));
    if (axis.values.back().empty() || !seen.insert(axis.values.back()).second)
      throw Error(ExitCode::usage,
                  axis.key + ": a value is empty or there twice. Write section.key=a,b,c");
    at = end + 1;
  }
  return axis;
}

std::vector<BatchCase> make_variants(const std::vector<SweepAxis>& axes, const Config& config) {
  constexpr std::size_t kMost = 1000;
  std::vector<BatchCase> variants{{}};
  std::set<std::string> keys;
  for (const SweepAxis& axis : axes) {
    if (!keys.insert(axis.key).second) throw OptionError(axis.key + " is given twice");
    std::vector<BatchCase> more;
    for (const BatchCase& variant : variants)
      for (const std::string& value : axis.values) {
        BatchCase one = variant;
        one.name += (one.name.empty() ? "" : "_") + name_of(axis, value);
        one.settings.push_back(axis.key + "=" + value);
        more.push_back(std::move(one));
      }
    variants = std::move(more);
    if (variants.size() > kMost)
      throw Error(ExitCode::usage,
                  fmt::format("the sweep has more than {} variants. Give fewer values", kMost));
  }
  std::set<std::string> names;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    Config changed = config;
    for (const std::string& setting : variants[v].settings) apply_setting(changed, setting);
    changed.validate();
    constexpr std::size_t kLongestName = 90;
    std::string& name = variants[v].name;
    if (name.size() > kLongestName || !names.insert(name).second)
      name = fmt::format("variant-{:03d}", v + 1);
  }
  return variants;
}

void seed_variant(const fs::path& base, const fs::path& variant) {
  if (fs::exists(variant / "run.json")) return;
  fs::create_directories(variant);
  const auto link = [](const fs::path& from, const fs::path& to) {
    std::error_code error;
    fs::create_hard_link(from, to, error);
    if (error) fs::copy_file(from, to, fs::copy_options::overwrite_existing);
  };
  for (const Stage stage :
       {Stage::segmentation, Stage::centerline, Stage::meshing, Stage::simulation}) {
    const fs::path folder = base / name(stage);
    if (!fs::exists(folder)) continue;
    fs::create_directories(variant / name(stage));
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const fs::path to = variant / fs::relative(entry.path(), base);
      if (entry.is_directory())
        fs::create_directories(to);
      else
        link(entry.path(), to);
    }
  }
  // run.json last: a variant that has none is begun again.
  for (const char* file : {"case.toml", "metrics.json", "run.json"})
    if (fs::exists(base / file)) write_text_atomically(variant / file, read_text(base / file));
}

const std::vector<SweepMeasure>& sweep_measures() {
  static const std::vector<SweepMeasure> kMeasures = {
      {"/lesion/mld_mm", "mld_before_mm", "MLD before [mm]"},
      {"/result/mld_mm", "mld_after_mm", "MLD after [mm]"},
      {"/result/acute_gain_mm", "acute_gain_mm", "acute gain [mm]"},
      {"/result/recoil_percent", "recoil_percent", "recoil [% of the lumen at peak]"},
      {"/result/diameter_stenosis_percent", "residual_stenosis_percent", "residual stenosis [%]"},
      {"/balloon/balloon_to_artery_ratio", "balloon_to_artery_ratio", "balloon-to-artery ratio"},
      {"/wall/over_strength_percent", "over_strength_percent", "wall over its strength [%]"},
      {"/flow/ffr_after", "ffr_after", "pressure behind the lesion after / inlet's"}};
  return kMeasures;
}

SweepRow read_variant(const fs::path& folder, const BatchCase& variant) {
  SweepRow row{variant, "failed", "", std::vector<double>(sweep_measures().size(), kNone)};
  const fs::path file = folder / variant.name / "metrics.json";
  const json metrics = fs::exists(file) ? json::parse(read_text(file), nullptr, false) : json();
  if (!metrics.is_object()) return row;
  const auto words = [&](const char* key) {
    return metrics.contains(key) && metrics[key].is_string() ? metrics[key].get<std::string>()
                                                             : std::string();
  };
  if (!words("status").empty()) row.status = words("status");
  row.reason = words("status_reason");
  if (row.status != "done") return row;
  for (std::size_t m = 0; m < row.measures.size(); ++m) {
    const json::json_pointer pointer(sweep_measures()[m].pointer);
    if (metrics.contains(pointer) && metrics.at(pointer).is_number())
      row.measures[m] = metrics.at(pointer).get<double>();
  }
  return row;
}

void write_sweep(const fs::path& folder, const std::vector<SweepAxis>& axes,
                 const std::vector<SweepRow>& rows) {
  std::string csv;
  const auto add = [&](const formats::CsvRow& cells) {
    for (std::size_t c = 0; c < cells.size(); ++c)
      csv += (c == 0 ? "" : ",") + formats::csv_cell(cells[c]);
    csv += "\n";
  };
  add(header_of(axes));
  json variants = json::array();
  for (const SweepRow& row : rows) {
    add(cells_of(row, axes.size()));
    variants.push_back(json_of(row, axes));
  }
  write_text_atomically(folder / "sweep.csv", csv);
  write_text_atomically(folder / "sweep.json", json{{"variants", variants}}.dump(2) + "\n");
  const auto is_number = [](const std::string& value) {
    return formats::parse_number<double>(value).has_value();
  };
  if (std::all_of(axes[0].values.begin(), axes[0].values.end(), is_number))
    viewer::write_sweep_plot(folder / "sweep.svg", axes[0].key, panels_of(axes, rows));
}

std::string sweep_table(const std::vector<SweepAxis>& axes, const std::vector<SweepRow>& rows) {
  constexpr std::array<std::size_t, 5> kShown = {1, 2, 3, 4, 7};  // of the measures
  std::vector<formats::CsvRow> table(1);
  for (const SweepAxis& axis : axes) table[0].push_back(axis.key);
  table[0].emplace_back("status");
  for (const std::size_t m : kShown) table[0].emplace_back(sweep_measures()[m].column);
  for (const SweepRow& row : rows) {
    formats::CsvRow& cells = table.emplace_back();
    for (std::size_t a = 0; a < axes.size(); ++a) cells.push_back(value_of(row.variant, a));
    cells.push_back(row.status);
    for (const std::size_t m : kShown)
      cells.push_back(std::isnan(row.measures[m]) ? "-" : cell_of(row.measures[m]));
  }
  std::vector<std::size_t> width(table[0].size(), 0);
  for (const formats::CsvRow& cells : table)
    for (std::size_t c = 0; c < cells.size(); ++c) width[c] = std::max(width[c], cells[c].size());
  std::string text;
  for (const formats::CsvRow& cells : table) {
    for (std::size_t c = 0; c < cells.size(); ++c)
      text += fmt::format("{}{:>{}}", c == 0 ? "" : "  ", cells[c], width[c]);
    text += "\n";
  }
  return text;
}

}  // namespace angio::pipeline
