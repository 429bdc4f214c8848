#include "pipeline/config/config.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/require.hpp"
#include "core/text.hpp"
#include "pipeline/config/shared_quantities.hpp"

namespace angio::pipeline {
namespace {

void apply(Config& config, const std::string& key, const std::string& toml_value,
           const std::string& where) {
  const std::vector<Setting> table = settings(config);
  std::vector<std::string> keys;
  for (const Setting& setting : table) {
    if (setting.key == key) return setting.set(toml_value);
    keys.push_back(setting.key);
  }
  const std::string guess = guess_name(key, keys);
  throw OptionError(fmt::format("unknown key {} in {}{}. `angio run --print-config` lists all keys",
                                key, where,
                                guess.empty() ? "" : fmt::format(" (did you mean {}?)", guess)));
}

void apply_table(Config& config, const toml::table& table, const std::string& where) {
  for (const auto& [section, node] : table) {
    const std::string section_name(section.str());
    if (!node.is_table()) return apply(config, section_name, "0", where);  // no bare keys: refused
    for (const auto& [key, value] : *node.as_table()) {
      std::ostringstream text;
      text << toml::node_view<const toml::node>(value);
      apply(config, section_name + "." + std::string(key.str()), text.str(), where);
    }
  }
}

/// A chart is that of one balloon: of another size it says nothing.
void check_balloon_has_chart(double nominal_diameter_mm,
                             const std::vector<simulation::ChartPoint>& chart) {
  constexpr double kBeyond = 0.1;  // of a diameter: the chart may begin above the nominal pressure
  if (!(nominal_diameter_mm > 0.0) || chart.empty()) return;
  const double least = chart.front().diameter_mm, most = chart.back().diameter_mm;
  if (nominal_diameter_mm < (1.0 - kBeyond) * least || nominal_diameter_mm > (1.0 + kBeyond) * most)
    throw OptionError(fmt::format(
        "balloon.nominal_diameter_mm is {:g}, but balloon.chart is that of another balloon, {:g} "
        "to {:g} mm wide. Name the balloon that is meant, or take the chart away (balloon.chart = "
        "[], balloon.rest_diameter_mm = 0)",
        nominal_diameter_mm, least, most));
}

}  // namespace

void Config::validate() const {
  input.validate();
  reconstruction.validate();
  views.validate();
  if (!view_ends.empty() && (view_ends.size() % 4 != 0 || view_ends.size() < 8))
    throw OptionError(
        "views.ends: must be four numbers a view, of two views or more: column, row of the "
        "vessel's proximal end, then of its distal one");
  if (const std::size_t asked = input.view_numbers().size();
      !view_ends.empty() && asked != 0 && view_ends.size() != 4 * asked)
    throw OptionError(fmt::format(
        "views.ends: {} numbers for the {} views of input.views. Give four a view: column, row of "
        "the vessel's proximal end, then of its distal one",
        view_ends.size(), asked));
  for (const double place : view_ends)
    if (!(place >= 0.0))
      throw OptionError(fmt::format("views.ends: {:g} lies outside any picture", place));
  for (const double frame : view_frames)
    if (!(frame >= 1.0 && frame < 1e6 && frame == std::floor(frame)))
      throw OptionError("views.frames: must be numbers of frames from 1, one a view");
  segmentation.validate();
  centerline.validate();
  constexpr const char* kExperiments[] = {"",          "cloth", "unilateral",
                                          "bilateral", "ytype", "coronary"};
  if (std::find(std::begin(kExperiments), std::end(kExperiments), experiment) ==
      std::end(kExperiments))
    throw OptionError(fmt::format(
        "input.experiment = {} is none (there are: cloth, unilateral, bilateral, ytype, coronary)",
        experiment));
  lesion.validate();
  narrowing.validate();
  lumen_mesh.validate();
  lumen_volume.validate();
  balloon.validate();
  flow.validate();
  view.validate();
  wall_layers.validate();
  if (wall_model == simulation::WallModel::layered)
    wall_layer_options(wall_layers, simulation.wall.thickness_ratio).validate();
  check_balloon_has_chart(balloon.nominal_diameter_mm, simulation.balloon.chart);
  constexpr double kSomeDiameter = 3.0;  // what is left to the size is valid at any
  solver_options(simulation, plaque, balloon.shaft_diameter_mm, kSomeDiameter,
                 is_usual_balloon(simulation.balloon, balloon.rest_diameter_mm))
      .validate();
  require_within("simulation.write_every", write_every, 1, 10000);
}

Backend backend_of(std::string_view name) {
  if (name == "cpu") return Backend::cpu;
  return name == "cuda" ? Backend::cuda : Backend::automatic;
}

void load_config(Config& config, const std::filesystem::path& file) {
  toml::table table;
  try {
    table = toml::parse(read_text(file), file.filename().string());
  } catch (const toml::parse_error& error) {
    throw OptionError(
        fmt::format("{}, line {}: {} (not TOML). Correct it, or begin from the "
                    "case.toml of another case",
                    file.string(), error.source().begin.line, error.description()));
  }
  apply_table(config, table, file.filename().string());
}

void apply_setting(Config& config, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos)
    throw Error(ExitCode::usage, fmt::format("--set {} is not section.key=value", assignment));
  apply(config, std::string(assignment.substr(0, equals)),
        std::string(assignment.substr(equals + 1)), "--set");
}

std::string to_toml(const Config& config) {
  Config copy = config;
  std::vector<Setting> table = settings(copy);
  std::vector<std::string> sections;  // in the order of their first key
  std::map<std::string, std::string> text;
  for (const Setting& setting : table) {
    const std::size_t dot = setting.key.find('.');
    const std::string section = setting.key.substr(0, dot);
    if (text.find(section) == text.end()) sections.push_back(section);
    text[section] +=
        fmt::format("{} = {}  # {}\n", setting.key.substr(dot + 1), setting.get(), setting.help);
  }
  std::string toml =
      "# Every option in force. `angio run INPUT --config THIS -o CASE` repeats it.\n";
  for (const std::string& section : sections)
    toml += fmt::format("\n[{}]\n{}", section, text[section]);
  return toml;
}

}  // namespace angio::pipeline
