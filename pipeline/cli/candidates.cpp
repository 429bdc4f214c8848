#include "pipeline/cli/candidates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "core/error.hpp"
#include "formats/tokens.hpp"
#include "meshing/meshing.hpp"
#include "pipeline/cli/variants.hpp"
#include "pipeline/config/balloon_file.hpp"
#include "pipeline/config/shared_quantities.hpp"
#include "simulation/balloon_size.hpp"

namespace angio::pipeline {
namespace {

constexpr std::array kDiameterShares = {0.9, 1.0, 1.1};  // of the reference diameter
// [mm] in which balloons are usual; coronary ones end at 30 mm.
constexpr std::array kLengthsSold = {6.0,  8.0,  10.0, 12.0, 15.0, 20.0,
                                     25.0, 30.0, 40.0, 60.0, 80.0};
constexpr const char *kNominal = "nominal", *kRated = "rated";

/// A balloon to be tried, and the case's configuration with it.
struct Balloon {
  std::string name;
  double diameter_mm, nominal_atm, rated_atm;
  Config config;
};

/// @param option  that has the text among its values
double number_of(const std::string& text, const char* option, const char* expected) {
  const auto value = formats::parse_number<double>(text);
  if (!value || !(*value > 0.0))
    throw Error(ExitCode::usage,
                fmt::format("\"{}\" of {} cannot be used (expected {}). Write them with commas "
                            "between them",
                            text, option, expected));
  return *value;
}

std::vector<double> numbers_of(const std::vector<std::string>& texts, const char* option) {
  std::set<double> values;
  for (const std::string& text : texts)
    values.insert(number_of(text, option, "numbers over 0, in mm"));
  return {values.begin(), values.end()};
}

/// To a tenth, as a gauge is read; a rated pressure never upwards.
double tenth(double pressure_atm) { return std::round(10.0 * pressure_atm) / 10.0; }
double tenth_below(double pressure_atm) { return std::floor(10.0 * pressure_atm + 1e-9) / 10.0; }

/// The representative balloon of a diameter: the case's own, if it is one, in another size.
Balloon usual_balloon(double diameter_mm, const Config& config) {
  Balloon balloon{"", diameter_mm, 0.0, 0.0, config};
  Config& c = balloon.config;
  if (!is_usual_balloon(c.simulation.balloon, c.balloon.rest_diameter_mm)) {
    const Config fresh;
    c.simulation.balloon = fresh.simulation.balloon;
    c.simulation.inflation.rated_burst_atm = fresh.simulation.inflation.rated_burst_atm;
    c.balloon.rest_diameter_mm = fresh.balloon.rest_diameter_mm;
    c.balloon.start_diameter_mm = fresh.balloon.start_diameter_mm;
    c.balloon.shaft_diameter_mm = fresh.balloon.shaft_diameter_mm;
  }
  const simulation::BalloonSize size = simulation::balloon_size(diameter_mm);
  const double rated = c.simulation.inflation.rated_burst_atm;
  balloon.nominal_atm = tenth(size.nominal_pressure_atm);
  balloon.rated_atm = tenth_below(rated > 0.0 ? rated : size.rated_burst_atm);
  return balloon;
}

std::vector<Balloon> balloons_of(const CandidateRequest& request, const LesionSize& lesion,
                                 const Config& config) {
  std::vector<Balloon> balloons;
  if (!request.balloons.empty()) {
    const auto catalogue = balloon_catalogue(request.catalogue);
    const std::set<std::string> names(request.balloons.begin(), request.balloons.end());
    for (const std::string& name : names) {
      const simulation::CatalogueBalloon& entry = find_balloon(catalogue, name);
      balloons.push_back({name, entry.nominal_diameter_mm, entry.nominal_pressure_atm,
                          entry.rated_burst_pressure_atm, config});
      apply_balloon(balloons.back().config, entry);
    }
  } else {
    std::set<double> diameters;
    for (const double diameter : numbers_of(request.diameters, "--diameters"))
      diameters.insert(diameter);
    for (std::size_t i = 0; i < kDiameterShares.size() && request.diameters.empty(); ++i)
      diameters.insert(
          meshing::usual_balloon_diameter_mm(kDiameterShares[i] * lesion.reference_diameter_mm));
    for (const double diameter : diameters) balloons.push_back(usual_balloon(diameter, config));
  }
  std::stable_sort(balloons.begin(), balloons.end(), [](const Balloon& a, const Balloon& b) {
    return a.diameter_mm < b.diameter_mm;
  });
  return balloons;
}

/// The shortest length sold that covers the lesion, and the next one, if that diameter has one.
std::vector<double> covering_lengths(const LesionSize& lesion, double diameter_mm) {
  const double covering = meshing::usual_balloon_length_mm(lesion.length_mm, diameter_mm),
               longest = meshing::usual_balloon_length_mm(kLengthsSold.back(), diameter_mm);
  std::vector<double> lengths;
  for (const double length : kLengthsSold)
    if (length >= covering && length <= longest && lengths.size() < 2) lengths.push_back(length);
  if (lengths.empty()) lengths.push_back(covering);
  return lengths;
}

struct Pressure {
  double atm;
  std::string name;
};

std::vector<Pressure> pressures_of(const CandidateRequest& request, const Balloon& balloon) {
  std::map<double, std::string> pressures;  // equal ones once, by their name
  const std::vector<std::string> both = {kNominal, kRated};
  for (const std::string& text : request.pressures.empty() ? both : request.pressures)
    if (text == kNominal)
      pressures[balloon.nominal_atm] = text;
    else if (text == kRated)
      pressures.emplace(balloon.rated_atm, text);
    else
      pressures.emplace(
          number_of(text, "--pressures", "numbers over 0, in atm, or nominal or rated"), "");
  std::vector<Pressure> result;
  for (const auto& [atm, name] : pressures) result.push_back({atm, name});
  return result;
}

/// What makes one configuration of another.
std::vector<std::string> changes(const Config& from, const Config& to) {
  Config before = from, after = to;
  const std::vector<Setting> olds = settings(before), news = settings(after);
  std::vector<std::string> changed;
  for (std::size_t s = 0; s < olds.size(); ++s) {
    const std::string value = news[s].get();
    if (value != olds[s].get()) changed.push_back(news[s].key + "=" + value);
  }
  return changed;
}

Candidate candidate_of(const Balloon& balloon, double length_mm, const Pressure& pressure,
                       const Config& config) {
  Candidate candidate{balloon.name, balloon.diameter_mm, length_mm,
                      pressure.atm, pressure.name,       {}};
  Config changed = balloon.config;
  const std::vector<std::string> own = {
      fmt::format("balloon.nominal_diameter_mm={}", balloon.diameter_mm),
      fmt::format("balloon.length_mm={}", length_mm),
      fmt::format("inflation.peak_pressure_atm={}", pressure.atm)};
  for (const std::string& setting : own) apply_setting(changed, setting);
  changed.validate();
  candidate.variant.name = fmt::format(
      "{}x{}mm-{}atm",
      balloon.name.empty() ? fmt::format("{}", balloon.diameter_mm) : balloon.name + "-", length_mm,
      pressure.atm);
  candidate.variant.settings = own;
  const auto key_of = [](const std::string& setting) {
    return setting.substr(0, setting.find('='));
  };
  for (const std::string& setting : changes(config, changed))
    if (std::none_of(own.begin(), own.end(),
                     [&](const std::string& one) { return key_of(one) == key_of(setting); }))
      candidate.variant.settings.push_back(setting);
  return candidate;
}

}  // namespace

std::vector<Candidate> make_candidates(const CandidateRequest& request, const LesionSize& lesion,
                                       const Config& config) {
  const bool is_every = !request.lengths.empty() || !request.pressures.empty();
  const std::vector<double> asked = numbers_of(request.lengths, "--lengths");
  std::vector<Candidate> candidates;
  for (const Balloon& balloon : balloons_of(request, lesion, config)) {
    const std::vector<double> lengths =
        asked.empty() ? covering_lengths(lesion, balloon.diameter_mm) : asked;
    for (const double length : lengths)
      for (const Pressure& pressure : pressures_of(request, balloon)) {
        if (!is_every && length > lengths.front() && pressure.name != kNominal) continue;
        candidates.push_back(candidate_of(balloon, length, pressure, config));
        if (candidates.size() > kMostVariants)
          throw Error(ExitCode::usage, fmt::format("there are more than {} candidates. Give fewer "
                                                   "values",
                                                   kMostVariants));
      }
  }
  return candidates;
}

}  // namespace angio::pipeline
