#include "pipeline/cli/recommend.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "core/atomic_file.hpp"
#include "core/clinical_limits.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/metrics.hpp"
#include "viewer/sweep_plot.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr double kPercents = 1.0, kRatios = 0.01, kAtmospheres = 0.1,
                 kVolumes = 0.1;  // what numbers are told to

constexpr const char *kResidual = "residual_stenosis_percent", *kRecoil = "recoil_percent",
                     *kInjury = "over_strength_mm3", *kRatio = "balloon_to_artery_ratio",
                     *kWidening = "widening_beside_lesion", *kFlow = "ffr_after",
                     *kPressure = "rated_burst_atm";

double to_steps_of(double step, double value) { return step * std::round(value / step); }

using limits::is_over;

/// A number of metrics.json; NaN: none.
double number_at(const json& metrics, const char* pointer) {
  const json::json_pointer at(pointer);
  return metrics.is_object() && metrics.contains(at) && metrics.at(at).is_number()
             ? metrics.at(at).get<double>()
             : kNotMeasured;
}

bool is_coronary(const json& metrics) {
  const json::json_pointer vessel("/flow/vessel");
  return metrics.is_object() && metrics.contains(vessel) && metrics.at(vessel) == "coronary";
}

/// Candidates are compared on one lesion.
bool is_lesion_of(const json& metrics, const TreatedLesion& lesion) {
  const double line = number_at(metrics, "/lesion/centerline_id"),
               place = number_at(metrics, "/lesion/abscissa_mm");
  return line == double(lesion.centerline_id) &&
         std::abs(place - lesion.abscissa_mm) <= 0.5 * lesion.size.length_mm;
}

void ask_limits(CandidateResult& result, const json& metrics) {
  const auto miss = [&](const char* limit, std::string text) {
    result.missed.push_back({limit, std::move(text)});
  };
  const double residual = measure_of(result.row, kResidual), ratio = measure_of(result.row, kRatio),
               ffr = measure_of(result.row, kFlow);
  if (is_over(residual, limits::kMostResidualStenosisPercent, kPercents))
    miss(kResidual, fmt::format("residual stenosis {:.0f} % (at most {:.0f} %)", residual,
                                limits::kMostResidualStenosisPercent));
  if (is_over(ratio, limits::kMostBalloonToArteryRatio, kRatios))
    miss(kRatio, fmt::format("balloon-to-artery ratio {:.2f} (at most {:.2f})", ratio,
                             limits::kMostBalloonToArteryRatio));
  const double widening = measure_of(result.row, kWidening);
  if (is_over(widening, limits::kMostWideningBeside, kRatios))
    miss(kWidening, fmt::format("widens the vessel beside the lesion {:.2f} times (at most {:.2f})",
                                widening, limits::kMostWideningBeside));
  result.is_coronary = is_coronary(metrics);
  if (!result.is_coronary)
    result.notes.emplace_back(
        "fractional flow reserve is not asked: nothing says that the vessel is a coronary artery "
        "(flow.vessel)");
  else if (std::isnan(ffr))
    result.notes.emplace_back("fractional flow reserve is not asked: it is not known");
  else if (!is_over(ffr, limits::kFlowLimitingFfr, kRatios))
    miss(kFlow, fmt::format("fractional flow reserve {:.2f} (over {:.2f})", ffr,
                            limits::kFlowLimitingFfr));
  const double rated = number_at(metrics, "/balloon/rated_burst_atm"),
               peak = number_at(metrics, "/balloon/peak_pressure_atm");
  if (is_over(peak, rated, kAtmospheres))
    miss(kPressure, fmt::format("{:.1f} atm (rated burst {:.1f} atm)", peak, rated));
}

void take_notes(CandidateResult& result, const json& metrics) {
  const double placed = number_at(metrics, "/balloon/length_mm");
  if (placed < result.candidate.length_mm - 0.05)
    result.notes.push_back(fmt::format("the vessel had room for {:.1f} mm only", placed));
  if (std::isnan(measure_of(result.row, kInjury)))
    result.notes.emplace_back(
        "injury is not compared: only a layered wall has a strength (wall.model)");
  const json::json_pointer kinked("/balloon/kinked");
  if (metrics.contains(kinked) && metrics.at(kinked) == true)
    result.notes.emplace_back("the balloon kinks: what lies there is not to be trusted");
}

/// The order of equals.
auto size_of(const Candidate& c) {
  return std::tuple(c.diameter_mm, c.balloon, c.length_mm, c.pressure_atm);
}

std::string words_of(const Candidate& candidate) {
  const std::string size =
      candidate.balloon.empty()
          ? fmt::format("{} x {} mm", candidate.diameter_mm, candidate.length_mm)
          : fmt::format("{}, {} mm", candidate.balloon, candidate.length_mm);
  return fmt::format("{} at {} atm{}", size, candidate.pressure_atm,
                     candidate.pressure == "rated"     ? " (rated burst)"
                     : candidate.pressure == "nominal" ? " (nominal)"
                                                       : "");
}

std::string misses_of(const CandidateResult& result) {
  std::vector<std::string> texts;
  for (const Miss& miss : result.missed) texts.push_back(miss.text);
  return fmt::format("{}", fmt::join(texts, "; "));
}

std::string front_of(const CandidateResult& result, const char* none) {
  return result.ranked.front > 0 ? std::to_string(result.ranked.front) : none;
}

formats::CsvRow csv_header() {
  formats::CsvRow header = {"rank",      "front",        "variant",  "balloon", "diameter_mm",
                            "length_mm", "pressure_atm", "pressure", "status"};
  for (const VariantMeasure& measure : variant_measures()) header.emplace_back(measure.column);
  header.insert(header.end(), {"limits_missed", "reason", "notes"});
  return header;
}

formats::CsvRow csv_row(const CandidateResult& result) {
  const Candidate& c = result.candidate;
  formats::CsvRow cells = {std::to_string(result.ranked.rank),
                           front_of(result, ""),
                           c.variant.name,
                           c.balloon,
                           cell_of(c.diameter_mm),
                           cell_of(c.length_mm),
                           cell_of(c.pressure_atm),
                           c.pressure,
                           result.row.status};
  for (const double value : result.row.measures) cells.push_back(cell_of(value));
  cells.push_back(misses_of(result));
  cells.push_back(result.row.reason);
  cells.push_back(fmt::format("{}", fmt::join(result.notes, "; ")));
  return cells;
}

json text_or_null(const std::string& text) { return text.empty() ? json() : json(text); }

json json_of(const CandidateResult& result) {
  const Candidate& c = result.candidate;
  json missed = json::array();
  for (const Miss& miss : result.missed)
    missed.push_back({{"limit", miss.limit}, {"text", miss.text}});
  const bool is_determined = result.standing.certainty == Certainty::determined;
  return {{"rank", result.ranked.rank},
          {"front", is_determined ? json(result.ranked.front) : json()},
          {"variant", c.variant.name},
          {"balloon", text_or_null(c.balloon)},
          {"diameter_mm", c.diameter_mm},
          {"length_mm", c.length_mm},
          {"pressure_atm", c.pressure_atm},
          {"pressure", text_or_null(c.pressure)},
          {"status", result.row.status},
          {"reason", text_or_null(result.row.reason)},
          {"limits_missed", is_determined ? missed : json()},
          {"notes", result.notes},
          {"measures", measures_json(result.row)}};
}

json limits_json() {
  return {{kResidual, limits::kMostResidualStenosisPercent},
          {kRatio, limits::kMostBalloonToArteryRatio},
          {kWidening, limits::kMostWideningBeside},
          {kFlow, limits::kFlowLimitingFfr}};
}

void draw(const fs::path& file, std::vector<CandidateResult> results) {
  std::stable_sort(results.begin(), results.end(), [](const auto& a, const auto& b) {
    return size_of(a.candidate) < size_of(b.candidate);
  });
  const bool is_coronary = std::any_of(results.begin(), results.end(),
                                       [](const auto& result) { return result.is_coronary; });
  std::vector<VariantRow> rows;
  std::vector<double> diameters;
  std::vector<std::string> labels;
  for (const CandidateResult& result : results) {
    const Candidate& c = result.candidate;
    rows.push_back(result.row);
    diameters.push_back(c.diameter_mm);
    const std::string family = c.balloon.substr(0, c.balloon.find('-'));
    labels.push_back(fmt::format(
        "{}{} mm, {}", family.empty() ? "" : family + ", ", c.length_mm,
        c.pressure.empty() ? fmt::format("{} atm", c.pressure_atm) : c.pressure + " pressure"));
  }
  std::vector<viewer::SweepPanel> panels = panels_of(rows, diameters, labels);
  for (std::size_t m = 0; m < panels.size(); ++m) {
    const std::string column = variant_measures()[m].column;
    const json all = limits_json();
    if (all.contains(column) && (column != kFlow || is_coronary))
      panels[m].limit = all[column].get<double>();
  }
  panels.erase(panels.begin());  // before: of the lesion, not of the balloon
  if (!viewer::write_sweep_plot(file, "balloon's nominal diameter [mm]", panels)) fs::remove(file);
}

}  // namespace

TreatedLesion treated_lesion(const fs::path& case_folder) {
  const fs::path file = case_folder / formats::case_file::kPlacement;
  if (!fs::exists(file))
    throw InputError(
        fmt::format("{} has no mesh yet (the balloons are chosen by its lesion). Run "
                    "`angio run -o CASE --until meshing` first",
                    case_folder.string()));
  const json placement = read_json(file);
  const std::string status = placement.value("status", "done");
  if (status != "done")
    throw InputError(
        fmt::format("there is no stenosis to compare balloons on ({}). Choose a place "
                    "with lesion.centerline and lesion.abscissa_mm",
                    placement.value("status_reason", status)));
  const json& lesion = placement.at("lesion");
  return {{lesion.at("reference_diameter_mm").get<double>(), lesion.at("length_mm").get<double>()},
          lesion.at("centerline_id").get<int>(),
          lesion.at("abscissa_mm").get<double>()};
}

CandidateResult judge_candidate(const Candidate& candidate, const VariantRow& row,
                                const json& metrics, const TreatedLesion& lesion) {
  CandidateResult result{candidate, row, false, {}, {}, {}, {}};
  Standing& standing = result.standing;
  if (row.status == "done" && !is_lesion_of(metrics, lesion)) {
    result.row.status = "not_determined";
    result.row.reason = "the balloon does not fit this lesion: another one was treated";
    std::fill(result.row.measures.begin(), result.row.measures.end(), kNotMeasured);
  }
  standing.certainty = result.row.status == "done"             ? Certainty::determined
                       : result.row.status == "not_determined" ? Certainty::not_determined
                                                               : Certainty::failed;
  if (standing.certainty != Certainty::determined) return result;
  ask_limits(result, metrics);
  take_notes(result, metrics);
  standing.missed = int(result.missed.size());
  standing.measures = {to_steps_of(kPercents, measure_of(row, kResidual)),
                       to_steps_of(kPercents, measure_of(row, kRecoil)),
                       to_steps_of(kVolumes, measure_of(row, kInjury)),
                       -to_steps_of(kRatios, measure_of(row, kFlow))};
  return result;
}

void rank_results(std::vector<CandidateResult>& results) {
  std::vector<Standing> standings;
  for (const CandidateResult& result : results) standings.push_back(result.standing);
  const std::vector<Ranked> ranked = rank_candidates(standings);
  for (std::size_t c = 0; c < results.size(); ++c) results[c].ranked = ranked[c];
  std::stable_sort(results.begin(), results.end(), [](const auto& a, const auto& b) {
    return std::pair(a.ranked.rank, size_of(a.candidate)) <
           std::pair(b.ranked.rank, size_of(b.candidate));
  });
}

std::string ranking_rule() {
  return fmt::format(
      "Rank: determined results before not_determined before failed; then fewest limits missed "
      "(residual stenosis at most {:.0f} %, balloon-to-artery ratio at most {:.2f}, widening "
      "beside the lesion at most {:.2f}, fractional "
      "flow "
      "reserve of a coronary artery over {:.2f}, pressure at most rated burst); then by fronts of "
      "Pareto dominance over residual stenosis, recoil, wall over its strength, and pressure "
      "behind "
      "the lesion; then least residual stenosis. Equals share a rank. Numbers are compared as "
      "printed: whole percents, tenths of mm3, hundredths.",
      limits::kMostResidualStenosisPercent, limits::kMostBalloonToArteryRatio,
      limits::kMostWideningBeside, limits::kFlowLimitingFfr);
}

std::string recommendation_table(const std::vector<CandidateResult>& results) {
  static const std::map<std::string, std::string> kShort = {{kResidual, "residual"},
                                                            {kRatio, "ratio"},
                                                            {kWidening, "beside"},
                                                            {kFlow, "ffr"},
                                                            {kPressure, "burst"}};
  std::vector<formats::CsvRow> table = {{"rank", "front", "balloon_mm", "length_mm", "atm",
                                         "status", "gain_mm", "residual_%", "recoil_%",
                                         "over_strength_mm3", "ratio", "beside", "ffr", "misses"}};
  for (const CandidateResult& result : results) {
    const Candidate& c = result.candidate;
    const auto told = [&](const char* column, int decimals) {
      const double value = measure_of(result.row, column);
      return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, decimals);
    };
    std::vector<std::string> misses;
    for (const Miss& miss : result.missed) misses.push_back(kShort.at(miss.limit));
    table.push_back({std::to_string(result.ranked.rank), front_of(result, "-"),
                     c.balloon.empty() ? cell_of(c.diameter_mm) : c.balloon, cell_of(c.length_mm),
                     cell_of(c.pressure_atm), result.row.status, told("acute_gain_mm", 2),
                     told(kResidual, 0), told(kRecoil, 0), told(kInjury, 1), told(kRatio, 2),
                     told(kWidening, 2), told(kFlow, 2),
                     misses.empty() ? "-" : fmt::format("{}", fmt::join(misses, ","))});
  }
  return aligned_text(table);
}

std::string recommendation_words(const std::vector<CandidateResult>& results) {
  std::vector<std::string> first;
  std::map<std::string, std::vector<std::string>> notes;
  for (const CandidateResult& result : results) {
    if (result.ranked.rank == 1) first.push_back(words_of(result.candidate));
    for (const std::string& note : result.notes) notes[note].push_back(words_of(result.candidate));
  }
  std::string text;
  if (results.empty() || results[0].standing.certainty != Certainty::determined)
    text = "No candidate has a determined result: recommendation.csv says why.\n";
  else
    text = fmt::format("{}First: {}.{}\n",
                       results[0].missed.empty() ? "" : "No candidate meets all limits. ",
                       fmt::join(first, ", and "),
                       results[0].missed.empty() ? " All limits are met."
                                                 : " Missed: " + misses_of(results[0]) + ".");
  for (const auto& [note, whose] : notes)
    text +=
        fmt::format("Note, of {}: {}.\n",
                    whose.size() == results.size() ? std::string("all")
                                                   : fmt::format("{}", fmt::join(whose, ", and ")),
                    note);
  if (!results.empty() && results[0].ranked.front > 0)
    text +=
        "Front: of candidates that miss as many limits, those of front 1 are beaten by none (as "
        "good in residual stenosis, recoil, wall over its strength and pressure behind the lesion, "
        "and better in one of them), those of front 2 by front 1 alone.\n";
  return text + "A comparison of simulations for research, not medical advice.\n";
}

void write_recommendation(const fs::path& folder, const TreatedLesion& lesion,
                          const std::vector<CandidateResult>& results) {
  std::vector<formats::CsvRow> table = {csv_header()};
  json candidates = json::array();
  for (const CandidateResult& result : results) {
    table.push_back(csv_row(result));
    candidates.push_back(json_of(result));
  }
  write_text_atomically(folder / "recommendation.csv", csv_text(table));
  write_text_atomically(
      folder / "recommendation.json",
      json{{"lesion",
            {{"centerline_id", lesion.centerline_id},
             {"abscissa_mm", lesion.abscissa_mm},
             {"length_mm", lesion.size.length_mm},
             {"reference_diameter_mm", lesion.size.reference_diameter_mm}}},
           {"limits", limits_json()},
           {"rule", ranking_rule()},
           {"purpose", "a comparison of simulations for research, not medical advice"},
           {"candidates", candidates}}
              .dump(2) +
          "\n");
  draw(folder / "recommendation.svg", results);
}

}  // namespace angio::pipeline
