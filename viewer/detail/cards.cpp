#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/clinical_limits.hpp"
#include "core/units.hpp"
#include "formats/html.hpp"
#include "formats/text.hpp"
#include "viewer/detail/case_headline.hpp"
#include "viewer/detail/tables.hpp"

namespace angio::viewer::detail {
namespace {

/// Nothing of what has no value.
std::string card(const std::string& value, const std::string& label, const std::string& detail) {
  if (value == "–") return {};
  return "<div class=\"card\"><div class=\"value\">" + formats::escape_html(value) +
         "</div><div class=\"label\">" + formats::escape_html(label) +
         "</div><div class=\"detail\">" + formats::escape_html(detail) + "</div></div>";
}

std::string shown(const std::optional<double>& value, int decimals, const char* unit) {
  return value ? formats::fixed_text(*value, decimals) + unit : "–";
}

bool is_undetermined(const Metrics& metrics) { return metrics.text("status") == "not_determined"; }

/// A number of the result; where it is not determined, what two runs say.
/// @param range_key  null: what they say is not kept
std::string told(const Metrics& metrics, const char* key, const char* range_key, int decimals,
                 const char* unit) {
  const auto value = metrics.number("result", key);
  if (!value || !is_undetermined(metrics)) return shown(value, decimals, unit);
  const auto range = range_key != nullptr ? metrics.range("result", range_key) : std::nullopt;
  if (!range) return "not determined";
  return formats::fixed_text((*range)[0], decimals) + " to " +
         formats::fixed_text((*range)[1], decimals) + unit;
}

/// A bound where the throat is narrower than a voxel, so not measured; else empty.
std::string bound(const Metrics& metrics, const std::string& key, int decimals) {
  const auto least = metrics.number("lesion", "stenosis_at_least_percent"),
             voxel = metrics.number("lesion", "resolution_mm");
  if (!least || !voxel) return {};
  if (key == "diameter_stenosis_percent") return "≥ " + formats::fixed_text(*least, decimals);
  return "< " + formats::fixed_text(key == "mld_mm" ? *voxel : 0.25 * units::kPi * *voxel * *voxel,
                                    decimals);
}

/// The standard deviation of the throat's diameter where it is known: of vessels fitted to frames.
std::string spread(const Metrics& metrics, const std::string& key, int decimals) {
  const auto sd = metrics.number("lesion", "mld_sd_mm");
  return sd && key == "mld_mm" ? " ± " + formats::fixed_text(*sd, decimals) : std::string();
}

/// Before and after.
std::string change(const Metrics& metrics, const char* key, const char* range_key, int decimals,
                   const char* unit) {
  const std::string known = bound(metrics, key, decimals);
  const std::string before = known.empty() ? shown(metrics.number("lesion", key), decimals, "") +
                                                 spread(metrics, key, decimals)
                                           : known;
  if (!metrics.number("result", key)) return before + (before == "–" ? "" : unit);
  return before + " → " + told(metrics, key, range_key, decimals, unit);
}

/// Under a card: what there is to say of it.
std::string joined(const std::vector<std::string>& parts) {
  std::string words;
  for (const std::string& part : parts)
    if (!part.empty()) words += (words.empty() ? "" : ", ") + part;
  return words;
}

/// "at peak 2.90 mm"; empty: nothing was simulated.
std::string at_peak(const Metrics& metrics, const char* key, const char* unit) {
  const auto value = metrics.number("peak", key);
  return value ? "at peak " + shown(value, 2, unit) : std::string();
}

/// By how much two runs differ; nothing is said beyond the last digit shown.
std::string agreement(const Metrics& metrics, const char* range_key, int decimals,
                      const char* unit) {
  const auto range = metrics.range("result", range_key);
  if (!range || is_undetermined(metrics)) return {};
  const double apart = std::max((*range)[1] - (*range)[0], std::pow(10.0, -decimals));
  return ", two runs within " + formats::fixed_text(apart, decimals) + unit;
}

/// By how much a lumen that the balloon fills is wider than the balloon: contact keeps a gap on
/// both sides, and of two round surfaces that touch along the edges of their meshes each lies up to
/// edge^2 / (8 radius) inside its circle, on both sides too.
double most_beyond_balloon(const Metrics& metrics, double balloon_mm) {
  const double gap = metrics.number("peak", "contact_gap_mm").value_or(0.0),
               edge = metrics.number("mesh", "mean_edge_mm").value_or(0.0);
  return 2.0 * gap + edge * edge / balloon_mm;
}

/// By how much the lumen at peak is wider than the balloon in it, and why.
std::string beyond_balloon(const Metrics& metrics) {
  constexpr double kWorthSaying = 0.02;  // mm
  const auto lumen = metrics.number("peak", "mld_mm"),
             balloon = metrics.number("balloon", "peak_diameter_mm");
  if (!lumen || !balloon || *balloon <= 0.0 || *lumen - *balloon < kWorthSaying) return {};
  const std::string beyond = formats::fixed_text(*lumen - *balloon, 2);
  if (*lumen - *balloon > most_beyond_balloon(metrics, *balloon))
    return " (the balloon does not fill the lumen: it is " + beyond + " mm narrower)";
  return " (" + beyond + " mm more than the balloon: contact's gap, and the meshes' edges)";
}

/// Nothing where no place was looked at.
std::string view_card(const Metrics& metrics) {
  const auto foreshortening = metrics.number("working_view", "foreshortening_percent");
  if (!foreshortening) return {};
  const bool is_assumed = metrics.text("working_view", "patient_axes") == "assumed";
  return card(metrics.text("working_view", "label"), "Best working view",
              "foreshortening " + shown(foreshortening, 0, " %") + ", overlap " +
                  shown(metrics.number("working_view", "overlap_percent"), 0, " %") +
                  (is_assumed ? "; if the input's axes are the patient's" : ""));
}

/// Nothing where fractional flow reserve does not apply.
std::string flow_card(const Metrics& metrics) {
  const auto before = metrics.number("flow", "ffr_before"),
             after = metrics.number("flow", "ffr_after");
  if (!before) return {};
  const bool is_told = after && !is_undetermined(metrics);
  const bool is_measured = !metrics.number("lesion", "stenosis_at_least_percent");
  std::string value = is_measured ? shown(before, 2, "") : "–";
  if (after) value += " → " + (is_told ? shown(after, 2, "") : "not determined");
  const auto range = [&](const char* when, const char* key) {
    const auto ends = metrics.range("flow", key);
    return ends ? when + formats::fixed_text((*ends)[0], 2) + " to " +
                      formats::fixed_text((*ends)[1], 2)
                : std::string();
  };
  std::string detail =
      is_measured ? range("before ", "ffr_before_range")
                  : "before not known: the throat is narrower than the voxels that show it";
  if (is_told) detail += range(", after ", "ffr_after_range");
  if (is_told && is_measured && metrics.number("lesion", "listed_count").value_or(0.0) > 1.0)
    detail += "; the tree's least " + shown(metrics.number("flow", "least_ffr_before"), 2, " → ") +
              shown(metrics.number("flow", "least_ffr_after"), 2, "");
  if (!is_coronary(metrics))
    return card(value, "Pressure behind the lesion, estimated",
                detail + " of the inlet's, at the greatest flow (hyperaemia)");
  return card(
      value, "Fractional flow reserve, estimated",
      detail + "; " + formats::fixed_text(limits::kFlowLimitingFfr, 2) + " and less limits flow");
}

}  // namespace

bool is_coronary(const Metrics& metrics) { return metrics.text("flow", "vessel") == "coronary"; }

std::string status_notice(const Metrics& metrics) {
  constexpr std::array<std::array<const char*, 2>, 4> kTitles{
      {{"no_lesion", "No certain stenosis."},
       {"not_determined", "No treatment simulated."},
       {"failed", "Failed: there is no result."},
       {"stale", "Out of date: there is no result."}}};
  const std::string status = metrics.text("status");
  const bool is_treated = metrics.number("result", "mld_mm").has_value();
  std::string reason = metrics.text("status_reason");
  if (!reason.empty()) reason[0] = char(std::toupper(static_cast<unsigned char>(reason[0])));
  for (const auto& [name, title] : kTitles)
    if (status == name)
      return "<div class=\"notice status\"><strong>" +
             std::string(status == "not_determined" && is_treated ? "Not determined." : title) +
             "</strong> " + formats::escape_html(reason) + "</div>\n";
  return {};
}

namespace {

/// Empty: nothing was simulated.
std::string gain(const Metrics& metrics) {
  if (!metrics.number("result", "acute_gain_mm")) return {};
  return "acute gain " + told(metrics, "acute_gain_mm", "acute_gain_range_mm", 2, " mm") +
         agreement(metrics, "acute_gain_range_mm", 3, " mm");
}

/// Neither a stenosis nor a balloon: the vessel may be narrower elsewhere, where it is a thinner
/// one.
bool is_only_a_place(const Metrics& metrics) {
  return metrics.text("status") == "no_lesion" && !metrics.number("result", "mld_mm");
}

std::string diameter_card(const Metrics& metrics, const std::string& reference) {
  const std::string gained = gain(metrics);
  std::string detail =
      joined({reference, at_peak(metrics, "mld_mm", " mm") + beyond_balloon(metrics), gained});
  if (!bound(metrics, "mld_mm", 2).empty())
    detail += std::string(detail.empty() ? "" : ". ") +
              "Before, the throat is narrower than the voxels that show it: it is not measured" +
              (gained.empty() ? "" : ", and the gain not certain");
  return card(change(metrics, "mld_mm", "mld_range_mm", 2, " mm"),
              is_only_a_place(metrics) ? "Lumen diameter there" : "Minimal lumen diameter", detail);
}

/// What a balloon did; nothing where there was none.
std::string balloon_cards(const Metrics& metrics) {
  const auto balloon = [&](const char* key) { return metrics.number("balloon", key); };
  std::string out;
  if (metrics.number("result", "recoil_mm"))
    out += card(told(metrics, "recoil_mm", nullptr, 2, " mm"), "Elastic recoil",
                told(metrics, "recoil_percent", "recoil_range_percent", 0, " %") +
                    " of the lumen at peak" +
                    agreement(metrics, "recoil_range_percent", 1, " points"));
  if (balloon("nominal_diameter_mm"))
    out += card(shown(balloon("nominal_diameter_mm"), 2, "") + " × " +
                    length_text(balloon("length_mm").value_or(0.0)) + " mm",
                "Balloon",
                balloon("balloon_to_artery_ratio")
                    ? "balloon-to-artery ratio " + shown(balloon("balloon_to_artery_ratio"), 2, "")
                    : "");
  if (balloon("peak_pressure_atm"))
    out += card(shown(balloon("peak_pressure_atm"), 1, " atm"), "Peak pressure",
                balloon("peak_diameter_mm")
                    ? "balloon at peak " + shown(balloon("peak_diameter_mm"), 2, " mm")
                    : "");
  if (const auto over = metrics.number("wall", "over_strength_percent"))
    out += card(shown(over, 0, " %"), "Wall over its strength",
                "of intima, media and adventitia where the balloon touches");
  return out;
}

/// Empty: this is the only stenosis.
std::string others_listed(const Metrics& metrics) {
  const auto listed = metrics.number("lesion", "listed_count");
  return listed && *listed > 1.0
             ? formats::fixed_text(*listed, 0) + " stenoses are listed, this one is looked at"
             : std::string();
}

std::string headline_cards(const Metrics& metrics) {
  const auto lesion = [&](const char* key) { return metrics.number("lesion", key); };
  const std::string status = metrics.text("status"),
                    reference =
                        "reference diameter " + shown(lesion("reference_diameter_mm"), 2, " mm");
  const bool has_lesion = status != "no_lesion";  // else its percentage would be no stenosis'
  std::string out;
  if (has_lesion)
    out += card(change(metrics, "diameter_stenosis_percent", nullptr, 0, " %"), "Diameter stenosis",
                joined({reference, others_listed(metrics)}));
  out += diameter_card(metrics, has_lesion ? "" : reference);
  out += card(change(metrics, "mla_mm2", nullptr, 2, " mm²"),
              is_only_a_place(metrics) ? "Lumen area there" : "Minimal lumen area",
              at_peak(metrics, "mla_mm2", " mm²"));
  out += flow_card(metrics);
  out += view_card(metrics);
  if (status == "failed" || status == "stale") return out;
  return out + balloon_cards(metrics);
}

}  // namespace

std::string headline(const Metrics& metrics) {
  const std::string cards = headline_cards(metrics);
  if (metrics.text("status") != "no_lesion") return "<div class=\"cards\">" + cards + "</div>\n";
  const bool is_tried = metrics.number("result", "mld_mm").has_value();
  return "<div class=\"trial\"><p><strong>" +
         std::string(is_tried ? "Trial inflation, not a treatment." : "The place for a trial.") +
         "</strong> " +
         (is_tried
              ? "What a balloon does in the longest vessel, where it is narrow and has room; no "
                "stenosis is certain there."
              : "No stenosis is certain there, and no balloon was tried.") +
         "</p><div class=\"cards\">" + cards + "</div></div>\n";
}

}  // namespace angio::viewer::detail
