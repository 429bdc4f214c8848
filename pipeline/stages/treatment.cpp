#include "pipeline/stages/treatment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/clinical_limits.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"
#include "pipeline/case/case_files.hpp"

namespace angio::pipeline {
namespace {

using nlohmann::json;

constexpr double kLargestShare = 0.1;
constexpr double kLeastDifference = 0.02;  // [mm]

constexpr double kWorthSaying = 0.5;  // [mm]

constexpr const char* kWhatToTry =
    "Try a smaller or shorter balloon (balloon.nominal_diameter_mm, balloon.length_mm), or a finer "
    "wall (mesh.edges_per_circumference)";

double diameter_of(double area) { return 2.0 * std::sqrt(area / units::kPi); }

json range_of(double a, double b) { return json::array({std::min(a, b), std::max(a, b)}); }

}  // namespace

std::vector<Stretch> lesions_on(const CenterlinePath& path, const json& lesions,
                                const CenterlineTree& tree) {
  std::vector<Stretch> stretches;
  for (const json& lesion : lesions) {
    const CenterlinePath& its = path_of(tree, lesion.at("centerline_id").get<int>());
    const auto parting =
        std::mismatch(its.points.begin(), its.points.end(), path.points.begin(), path.points.end());
    const auto shared_count = std::size_t(parting.first - its.points.begin());
    if (shared_count == 0) continue;
    const double shared_mm = its.abscissa[shared_count - 1];
    const double first = lesion.at("proximal_mm").get<double>();
    if (first < shared_mm)
      stretches.push_back({first, std::min(lesion.at("distal_mm").get<double>(), shared_mm)});
  }
  return stretches;
}

std::optional<WideningBeside> widening_beside(const centerline::LumenProfile& before,
                                              const centerline::LumenProfile& peak,
                                              const std::vector<Stretch>& lesions,
                                              double reference_mm) {
  const std::vector<double>& places = before.abscissa;
  std::optional<WideningBeside> most;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double s = places[i];
    if (std::any_of(lesions.begin(), lesions.end(), [&](const Stretch& lesion) {
          return s > lesion[0] - reference_mm && s < lesion[1] + reference_mm;
        }))
      continue;
    const auto at = std::lower_bound(peak.abscissa.begin(), peak.abscissa.end(), s);
    if (at == peak.abscissa.end() || *at != s) continue;
    const double wide = diameter_of(peak.section_area[std::size_t(at - peak.abscissa.begin())]);
    std::vector<double> around;
    for (std::size_t k = 0; k < places.size(); ++k)
      if (std::abs(places[k] - s) <= reference_mm)
        around.push_back(diameter_of(before.section_area[k]));
    const double own = std::max(diameter_of(before.section_area[i]), median(std::move(around)));
    if (!most || wide / own > most->ratio) most = WideningBeside{wide / own, s, own, wide};
  }
  return most;
}

std::vector<std::string> widening_warnings(const std::optional<WideningBeside>& widening,
                                           bool is_lesion) {
  constexpr double kHundredth = 0.01;  // what the ratio is told to
  if (!widening || !limits::is_over(widening->ratio, limits::kMostWideningBeside, kHundredth))
    return {};
  return {fmt::format(
      "beside {} the balloon widens the vessel from {:.1f} to {:.1f} mm, {:.1f} mm from "
      "the inlet: {:.2f} times, at most {:.1f} is asked. A shorter or a smaller balloon spares "
      "it (balloon.length_mm, balloon.nominal_diameter_mm)",
      is_lesion ? "the lesion" : "the place that it is tried at", widening->before_mm,
      widening->peak_mm, widening->abscissa_mm, widening->ratio, limits::kMostWideningBeside)};
}

GuardVerdict judge(const Treatment& first, const std::optional<Treatment>& second,
                   const std::string& second_failure) {
  if (!second)
    return {
        "failed",
        fmt::format("the result is not determined: a second run, from a start that nobody could "
                    "tell from the first one's, gave none ({})",
                    second_failure)};
  const double gain = std::abs(first.gain_mm() - second->gain_mm()),
               recoil = std::abs(first.recoil_mm() - second->recoil_mm());
  // Recoil against itself where it is the larger one: a healthy vessel gains next to nothing.
  const double of_gain = kLargestShare * std::max(first.gain_mm(), second->gain_mm()),
               of_recoil = kLargestShare * std::max(first.recoil_mm(), second->recoil_mm());
  if (gain <= std::max(of_gain, kLeastDifference) &&
      recoil <= std::max({of_gain, of_recoil, kLeastDifference}))
    return {"agrees", ""};
  const auto shown = [](double mm) { return std::round(1000.0 * mm) / 1000.0 + 0.0; };  // no -0
  return {"differs",
          fmt::format("the result is not determined: two runs, from starts that nobody could tell "
                      "apart, gave a gain of {:.3f} and {:.3f} mm and a recoil of {:.3f} and "
                      "{:.3f} mm, apart by more than {:.0f} %. {}",
                      shown(first.gain_mm()), shown(second->gain_mm()), shown(first.recoil_mm()),
                      shown(second->recoil_mm()), 100.0 * kLargestShare, kWhatToTry)};
}

json treatment_json(const Treatment& first, const std::optional<Treatment>& second,
                    double reference_mm, double balloon_mm) {
  const centerline::Tightest& after = first.after.lesion;
  const auto stenosis_of = [&](const TreatedMeasures& measures) {
    const double reference_area = 0.25 * units::kPi * reference_mm * reference_mm;
    const auto& eccentricity = measures.lumen_eccentricity;
    return json{
        {"mld_mm", measures.lesion.mld_mm},
        {"mla_mm2", measures.lesion.mla_mm2},
        {"diameter_stenosis_percent", 100.0 * (1.0 - measures.lesion.mld_mm / reference_mm)},
        {"area_stenosis_percent", 100.0 * (1.0 - measures.lesion.mla_mm2 / reference_area)},
        {"lumen_eccentricity", eccentricity ? json(*eccentricity) : json()},
        {"segment_mld_mm", measures.segment.mld_mm},
        {"segment_mla_mm2", measures.segment.mla_mm2}};
  };
  json ranges = {{"mld_range_mm", nullptr},
                 {"acute_gain_range_mm", nullptr},
                 {"recoil_range_percent", nullptr}};
  if (second)
    ranges = {{"mld_range_mm", range_of(after.mld_mm, second->after.lesion.mld_mm)},
              {"acute_gain_range_mm", range_of(first.gain_mm(), second->gain_mm())},
              {"recoil_range_percent", range_of(first.recoil_percent(), second->recoil_percent())}};
  json result = stenosis_of(first.after);
  result.update({{"acute_gain_mm", first.gain_mm()},
                 {"recoil_mm", first.recoil_mm()},
                 {"recoil_percent", first.recoil_percent()},
                 {"recoil_percent_of_balloon", 100.0 * (balloon_mm - after.mld_mm) / balloon_mm},
                 {"recoil_percent_of_gain", first.recoil_percent_of_gain()}});
  result.update(ranges);
  return {{"lesion", stenosis_of(first.before)},
          {"peak", stenosis_of(first.peak)},
          {"result", std::move(result)}};
}

std::vector<std::string> start_warnings(const TreatedMeasures& before, double measured_percent,
                                        double reference_mm) {
  constexpr double kMostApart = 10.0;  // points
  const double simulated = std::max(0.0, 100.0 * (1.0 - before.lesion.mld_mm / reference_mm));
  if (std::abs(measured_percent - simulated) <= kMostApart) return {};
  return {fmt::format(
      "before the balloon the lumen that is simulated is narrowed by {:.0f} %, the one that was "
      "measured by {:.0f} %: one of them is wrong (a sharp bend, a ragged wall, or a throat finer "
      "than the mesh). Look at the sections there",
      simulated, measured_percent)};
}

std::vector<std::string> treatment_warnings(const Treatment& treatment, const GuardVerdict& guard,
                                            const TreatedSpans& spans) {
  std::vector<std::string> warnings;
  if (!guard.reason.empty()) warnings.push_back(guard.reason);
  if (treatment.recoil_mm() < 0.0)
    warnings.push_back(fmt::format(
        "the recoil is negative: the lumen after deflation, {:.3f} mm, is wider than the balloon "
        "held it at its peak, {:.3f} mm (the wall moved on, or the narrowest place is another one)",
        treatment.after.lesion.mld_mm, treatment.peak.lesion.mld_mm));
  if (spans.untreated_mm > kWorthSaying)
    warnings.push_back(fmt::format(
        "the balloon leaves out {:.1f} mm of the lesion: MLD, gain and recoil are of the part that "
        "it treats, from {:.1f} to {:.1f} mm from the inlet; the MLD along the whole balloon is "
        "among all numbers. A longer balloon may reach the rest, unless open ends or a bend left "
        "no room for one (balloon.length_mm)",
        spans.untreated_mm, spans.lesion_first, spans.lesion_last));
  return warnings;
}

}  // namespace angio::pipeline
