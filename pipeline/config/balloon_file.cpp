#include "pipeline/config/balloon_file.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <cmath>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "pipeline/balloons_toml.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using simulation::CatalogueBalloon;
namespace {

/// One [[balloon]] of a file, to be read key by key.
class Entry {
 public:
  Entry(const std::string& file, std::size_t number, const toml::table& table)
      : file_(file), table_(table) {
    label_ = fmt::format("{}, balloon {}", file, number + 1);
    if (const auto text = table["name"].value<std::string>()) label_ += " (" + *text + ")";
  }

  void read(const char* key, std::string& field) {
    if (const toml::node* node = find(key)) {
      if (!node->is_string()) refuse(key, "a text");
      field = node->as_string()->get();
    }
  }
  void read(const char* key, double& field) {
    if (const toml::node* node = find(key)) field = number(key, *node);
  }
  void read(const char* key, int& field) {
    const toml::node* node = find(key);
    if (!node) return;
    const double value = number(key, *node);
    if (value != std::floor(value) || std::abs(value) > 1e6) refuse(key, "a whole number");
    field = int(value);
  }
  void read(const char* key, bool& field) {
    if (const toml::node* node = find(key)) {
      if (!node->is_boolean()) refuse(key, "true or false");
      field = node->as_boolean()->get();
    }
  }
  void read(const char* key, std::vector<simulation::ChartPoint>& field) {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_array()) refuse(key, "a list of [atm, mm]");
    for (const toml::node& point : *node->as_array()) {
      const toml::array* pair = point.as_array();
      if (!pair || pair->size() != 2) refuse(key, "a list of [atm, mm]");
      field.push_back({number(key, (*pair)[0]), number(key, (*pair)[1])});
    }
  }

  void refuse_unknown_keys() const {
    for (const auto& [key, unused] : table_) {
      const std::string word(key.str());
      if (std::find(known_.begin(), known_.end(), word) != known_.end()) continue;
      const std::string guess = guess_name(word, known_);
      throw InputError(fmt::format("{}: there is no key {}{}", label_, word,
                                   guess.empty() ? "" : fmt::format(" (did you mean {}?)", guess)));
    }
  }

 private:
  const toml::node* find(const char* key) {
    known_.emplace_back(key);
    return table_.get(key);
  }
  double number(const char* key, const toml::node& node) const {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value)) refuse(key, "a number");
    return *value;
  }
  [[noreturn]] void refuse(const char* key, const char* expected) const {
    throw InputError(fmt::format("{}: {} cannot be used (expected {})", label_, key, expected));
  }

  std::string file_;
  const toml::table& table_;
  std::string label_;
  std::vector<std::string> known_;
};

CatalogueBalloon balloon_of(Entry& entry) {
  CatalogueBalloon b;
  entry.read("name", b.name);
  entry.read("description", b.description);
  entry.read("nominal_diameter_mm", b.nominal_diameter_mm);
  entry.read("length_mm", b.length_mm);
  entry.read("wall_mm", b.wall_mm);
  entry.read("material", b.material);
  entry.read("nominal_pressure_atm", b.nominal_pressure_atm);
  entry.read("rated_burst_pressure_atm", b.rated_burst_pressure_atm);
  entry.read("chart", b.chart);
  entry.read("crossing_profile_mm", b.crossing_profile_mm);
  entry.read("folds", b.folds);
  entry.read("shaft_diameter_mm", b.shaft_diameter_mm);
  entry.read("source", b.source);
  entry.read("representative", b.representative);
  entry.refuse_unknown_keys();
  b.validate();
  return b;
}

std::vector<CatalogueBalloon> parse_catalogue(const std::string& text, const std::string& file) {
  toml::table table;
  try {
    table = toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw InputError(
        fmt::format("{}, line {}: {} (not TOML). See simulation/balloons.toml for an "
                    "example",
                    file, error.source().begin.line, error.description()));
  }
  const toml::array* balloons = table["balloon"].as_array();
  if (!balloons || balloons->empty() || table.size() != 1)
    throw InputError(file +
                     " is not a balloon catalogue (it must hold [[balloon]] tables and "
                     "nothing else)");
  std::vector<CatalogueBalloon> result;
  for (std::size_t i = 0; i < balloons->size(); ++i) {
    const toml::table* one = (*balloons)[i].as_table();
    if (!one) throw InputError(file + ": balloon must be tables, [[balloon]]");
    Entry entry(file, i, *one);
    result.push_back(balloon_of(entry));
    for (std::size_t k = 0; k < i; ++k)
      if (result[k].name == result[i].name)
        throw InputError(fmt::format("{}: two balloons are named {}", file, result[i].name));
  }
  return result;
}

}  // namespace

std::vector<CatalogueBalloon> read_balloon_file(const fs::path& file) {
  if (!fs::is_regular_file(file))
    throw InputError(fmt::format("there is no {} (no such balloon catalogue)", file.string()),
                     ExitCode::no_input);
  return parse_catalogue(read_text(file), file.filename().string());
}

std::vector<CatalogueBalloon> balloon_catalogue(const fs::path& file) {
  std::vector<CatalogueBalloon> all;
  if (!file.empty()) all = read_balloon_file(file);
  const std::size_t own = all.size();
  for (CatalogueBalloon& balloon : parse_catalogue(kBalloonsToml, "balloons.toml")) {
    const auto has_name = [&](const CatalogueBalloon& b) { return b.name == balloon.name; };
    if (std::none_of(all.begin(), all.begin() + std::ptrdiff_t(own), has_name))
      all.push_back(std::move(balloon));
  }
  return all;
}

void apply_balloon(Config& config, const CatalogueBalloon& balloon) {
  config.balloon.nominal_diameter_mm = balloon.nominal_diameter_mm;
  config.balloon.rest_diameter_mm = rest_diameter_mm(balloon);
  config.balloon.length_mm = balloon.length_mm;
  config.balloon.start_diameter_mm = balloon.crossing_profile_mm;
  config.balloon.shaft_diameter_mm = balloon.shaft_diameter_mm;
  simulation::BalloonMaterial& material = config.simulation.balloon;
  material.name = balloon.material;
  material.wall_mm = balloon.wall_mm;
  material.chart = balloon.chart;
  config.simulation.inflation.peak_pressure_atm = balloon.nominal_pressure_atm;
  config.simulation.inflation.rated_burst_atm = balloon.rated_burst_pressure_atm;
}

}  // namespace angio::pipeline
