#include "pipeline/case/dicom_measurements.hpp"

#include <optional>
#include <string>

namespace angio::pipeline {
namespace {

using dicom::Code;
using nlohmann::json;

Code own(const char* value, const char* meaning) { return {value, dicom::kPrivateScheme, meaning}; }

// Units, of UCUM.
const Code kMm{"mm", "UCUM", "mm"};
const Code kMm2{"mm2", "UCUM", "mm2"};
const Code kPercent{"%", "UCUM", "%"};
const Code kAtm{"atm", "UCUM", "atm"};
const Code kMmHg{"mm[Hg]", "UCUM", "mmHg"};
const Code kMlPerMin{"ml/min", "UCUM", "ml/min"};
const Code kOne{"1", "UCUM", "no units"};

const Code kMinimum{"255605001", "SCT", "Minimum"};
const Code kLumenDiameter{"G-0364", "SRT", "Vessel lumen diameter"};
const Code kLumenArea{"122480", "DCM", "Vessel Lumen Cross-Sectional Area"};
const Code kDiameterStenosis{"R-101BB", "SRT", "Lumen Diameter Stenosis"};
const Code kAreaStenosis{"R-101BA", "SRT", "Lumen Area Stenosis"};
const Code kPressureGradient{"251081004", "SCT", "Pressure Gradient"};

// What a group is about.
const Code kStenosis{"415582006", "SCT", "Stenosis"};
const Code kLumen{"91747007", "SCT", "Lumen of blood vessel"};
const Code kInflated{"122303", "DCM", "Angioplasty balloon inflated"};
const Code kDeflated{"122304", "DCM", "Angioplasty balloon deflated"};

/// A key of a group of metrics.json, and how it is told.
struct Term {
  const char* key;
  Code name;
  Code unit;
  std::optional<Code> derivation = std::nullopt;
};

std::vector<Term> lumen_terms() {
  return {{"mld_mm", kLumenDiameter, kMm, kMinimum},
          {"mla_mm2", kLumenArea, kMm2, kMinimum},
          {"diameter_stenosis_percent", kDiameterStenosis, kPercent}};
}

/// @param is_measured  whether the throat is: else it is narrower than a voxel
std::vector<Term> lesion_terms(bool is_measured) {
  std::vector<Term> terms;
  if (is_measured) {
    terms = lumen_terms();
    terms.push_back({"area_stenosis_percent", kAreaStenosis, kPercent});
  } else {
    terms.push_back({"stenosis_at_least_percent", kDiameterStenosis, kPercent, kMinimum});
  }
  terms.push_back({"reference_diameter_mm", own("REFERENCE_D", "Reference diameter"), kMm});
  terms.push_back({"length_mm", own("LESION_LENGTH", "Lesion length"), kMm});
  terms.push_back({"abscissa_mm", own("FROM_INLET", "Distance from the inlet"), kMm});
  return terms;
}

std::vector<Term> balloon_terms() {
  return {{"nominal_diameter_mm", own("BALLOON_NOMINAL", "Balloon nominal diameter"), kMm},
          {"length_mm", own("BALLOON_LENGTH", "Balloon length"), kMm},
          {"peak_pressure_atm", own("BALLOON_PRESSURE", "Balloon peak pressure"), kAtm},
          {"rated_burst_atm", own("RATED_BURST", "Balloon rated burst pressure"), kAtm},
          {"peak_diameter_mm", own("BALLOON_PEAK", "Balloon diameter at peak"), kMm},
          {"balloon_to_artery_ratio", own("BALLOON_RATIO", "Balloon to artery ratio"), kOne}};
}

std::vector<Term> result_terms() {
  std::vector<Term> terms = lumen_terms();
  terms.push_back({"acute_gain_mm", own("ACUTE_GAIN", "Acute gain"), kMm});
  terms.push_back({"recoil_mm", own("RECOIL", "Elastic recoil"), kMm});
  terms.push_back(
      {"recoil_percent", own("RECOIL_PERCENT", "Elastic recoil over lumen at peak"), kPercent});
  return terms;
}

/// Keys end with "_before" or "_after".
std::vector<Term> flow_terms(bool is_coronary, bool is_after) {
  const Code ratio = is_coronary ? own("FFR", "Fractional flow reserve, estimated")
                                 : own("PRESSURE_RATIO", "Distal over inlet pressure, estimated");
  if (is_after)
    return {{"ffr_after", ratio, kOne},
            {"pressure_drop_after_mmhg", kPressureGradient, kMmHg},
            {"flow_after_ml_min", own("FLOW", "Blood flow, estimated"), kMlPerMin}};
  return {{"ffr_before", ratio, kOne},
          {"pressure_drop_before_mmhg", kPressureGradient, kMmHg},
          {"flow_before_ml_min", own("FLOW", "Blood flow, estimated"), kMlPerMin}};
}

void add_terms(const json& metrics, const char* group, const std::vector<Term>& terms,
               std::vector<dicom::Measurement>& measurements) {
  if (!metrics.contains(group)) return;
  const json& values = metrics.at(group);
  for (const Term& term : terms) {
    const auto found = values.find(term.key);
    if (found == values.end() || !found->is_number()) continue;
    measurements.push_back({term.name, found->get<double>(), term.unit, term.derivation});
  }
}

/// One standard deviation to both sides, as two measurements.
void add_ffr_range(const json& metrics, const char* key,
                   std::vector<dicom::Measurement>& measurements) {
  if (!metrics.contains("flow")) return;
  const auto found = metrics["flow"].find(key);
  if (found == metrics["flow"].end() || !found->is_array() || found->size() != 2) return;
  if (!(*found)[0].is_number() || !(*found)[1].is_number()) return;
  measurements.push_back({own("RATIO_LOW", "The ratio, less one standard deviation"),
                          (*found)[0].get<double>(), kOne, std::nullopt});
  measurements.push_back({own("RATIO_HIGH", "The ratio, and one standard deviation"),
                          (*found)[1].get<double>(), kOne, std::nullopt});
}

}  // namespace

std::vector<dicom::MeasurementGroup> measurement_groups(const json& metrics) {
  const json status = metrics.value("status", json());
  const bool has_result = status == "done" || status == "no_lesion";
  const bool is_coronary =
      metrics.contains("flow") && metrics["flow"].value("vessel", json()) == "coronary";
  const bool has_lesion = status != "no_lesion";
  std::vector<dicom::MeasurementGroup> groups{
      {has_lesion ? "Lesion before" : "Narrowest place before",
       has_lesion ? kStenosis : kLumen,
       {}},
      {"At peak", kInflated, {}},
      {"After", kDeflated, {}}};
  const bool is_measured =
      !metrics.contains("lesion") ||
      !metrics["lesion"].value("stenosis_at_least_percent", json()).is_number();
  add_terms(metrics, "lesion", lesion_terms(is_measured), groups[0].measurements);
  if (is_measured) {
    add_terms(metrics, "flow", flow_terms(is_coronary, false), groups[0].measurements);
    add_ffr_range(metrics, "ffr_before_range", groups[0].measurements);
  }
  if (has_result) {
    add_terms(metrics, "peak", lumen_terms(), groups[1].measurements);
    add_terms(metrics, "balloon", balloon_terms(), groups[1].measurements);
    add_terms(metrics, "result", result_terms(), groups[2].measurements);
    add_terms(metrics, "flow", flow_terms(is_coronary, true), groups[2].measurements);
    add_ffr_range(metrics, "ffr_after_range", groups[2].measurements);
  }
  std::erase_if(groups, [](const auto& group) { return group.measurements.empty(); });
  return groups;
}

}  // namespace angio::pipeline
