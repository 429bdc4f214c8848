#include "simulation/balloon_catalogue.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "core/error.hpp"
#include "core/require.hpp"
#include "core/text.hpp"
#include "simulation/materials/material.hpp"

namespace angio::simulation {
namespace {

[[noreturn]] void fail(const CatalogueBalloon& balloon, const std::string& what) {
  throw InputError("the catalogue's balloon \"" + balloon.name + "\": " + what);
}

void check(const CatalogueBalloon& balloon, const char* field, double value, double low,
           double high) {
  const std::string fault = range_fault(field, value, low, high);
  if (!fault.empty()) fail(balloon, fault);
}

bool is_word(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
  });
}

// A chart and the nominal diameter are the same promise told twice.
void check_nominal(const CatalogueBalloon& balloon) {
  const double charted = chart_diameter_mm(balloon.chart, balloon.nominal_pressure_atm);
  if (std::isnan(charted) ||
      std::abs(charted - balloon.nominal_diameter_mm) <= 0.02 * balloon.nominal_diameter_mm)
    return;
  char text[200];
  std::snprintf(
      text, sizeof text,
      "its chart gives %.3f mm at the nominal %g atm (nominal_diameter_mm is %g). Correct "
      "one of them",
      charted, balloon.nominal_pressure_atm, balloon.nominal_diameter_mm);
  fail(balloon, text);
}

}  // namespace

void CatalogueBalloon::validate() const {
  if (!is_word(name))
    throw InputError("a balloon of the catalogue is named \"" + name.substr(0, 80) +
                     "\" (a name is a word of letters, digits, '.', '-' and '_'). Rename it");
  check(*this, "nominal_diameter_mm", nominal_diameter_mm, 0.5, 50.0);
  check(*this, "length_mm", length_mm, 0.5, 500.0);
  check(*this, "wall_mm", wall_mm, 0.001, 1.0);
  check(*this, "nominal_pressure_atm", nominal_pressure_atm, 1e-3, 100.0);
  check(*this, "rated_burst_pressure_atm", rated_burst_pressure_atm, nominal_pressure_atm, 100.0);
  check(*this, "crossing_profile_mm", crossing_profile_mm, 0.1, nominal_diameter_mm);
  check(*this, "shaft_diameter_mm", shaft_diameter_mm, 0.05, crossing_profile_mm);
  if (folds != 0 && folds != 2 && folds != 3 && folds != 5)
    fail(*this, "folds is " + std::to_string(folds) + " (0, 2, 3 or 5 are known)");
  if (!detail::is_named_material(material))
    fail(*this, "material is \"" + material + "\" (unknown). Use pa12, pet or polyurethane");
  if (!representative && source.empty())
    fail(*this, "it has no source (a product's figures need one). Name it, or set representative");
  if (chart.empty()) return;
  validate_chart(chart, name);
  check_nominal(*this);
}

const CatalogueBalloon& find_balloon(const std::vector<CatalogueBalloon>& catalogue,
                                     const std::string& name) {
  std::string list;
  std::vector<std::string> names;
  for (const CatalogueBalloon& balloon : catalogue) {
    if (balloon.name == name) return balloon;
    list += (list.empty() ? "" : ", ") + balloon.name;
    names.push_back(balloon.name);
  }
  const std::string guess = guess_name(name, names);
  throw InputError("no balloon \"" + name + "\" in the catalogue" +
                       (guess.empty() ? "" : ", did you mean " + guess + "?") + " (it has " + list +
                       "). Choose one of them, or add yours to the catalogue file",
                   ExitCode::bad_config);
}

double rest_diameter_mm(const CatalogueBalloon& balloon) {
  return balloon.chart.empty() ? balloon.nominal_diameter_mm : rest_diameter_mm(balloon.chart);
}

}  // namespace angio::simulation
