#include "viewer/detail/tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/error.hpp"
#include "core/units.hpp"
#include "formats/html.hpp"
#include "formats/text.hpp"

namespace angio::viewer::detail {
namespace {

using nlohmann::ordered_json;

struct Wording {
  const char* key;
  const char* label;
  const char* unit;
  int decimals;
};

/// The keys of docs/contract.md, "group.key", in the order of the tables.
constexpr std::array kWordings{
    Wording{"lesion.centerline_id", "Centreline", "", 0},
    Wording{"lesion.abscissa_mm", "Distance from the inlet", "mm", 1},
    Wording{"lesion.mld_mm", "Minimal lumen diameter (MLD)", "mm", 2},
    Wording{"lesion.mld_sd_mm", "One standard deviation of the MLD", "mm", 2},
    Wording{"lesion.mla_mm2", "Minimal lumen area (MLA)", "mm²", 2},
    Wording{"lesion.reference_diameter_mm", "Reference diameter", "mm", 2},
    Wording{"lesion.reference_rule", "Rule for the reference", "", 0},
    Wording{"lesion.reference_tree_mm", "Reference by the whole tree", "mm", 2},
    Wording{"lesion.reference_interpolated_mm", "Reference, interpolated", "mm", 2},
    Wording{"lesion.reference_proximal_mm", "Reference before the lesion", "mm", 2},
    Wording{"lesion.reference_distal_mm", "Reference behind the lesion", "mm", 2},
    Wording{"lesion.reference_average_mm", "Reference, average of both", "mm", 2},
    Wording{"lesion.widest_beside_mm", "Widest before and behind, their mean", "mm", 2},
    Wording{"lesion.beside_throat_mm", "Right before and behind the throat", "mm", 2},
    Wording{"lesion.diameter_stenosis_percent", "Diameter stenosis", "%", 1},
    Wording{"lesion.area_stenosis_percent", "Area stenosis", "%", 1},
    Wording{"lesion.lumen_eccentricity", "Eccentricity of the lumen, (widest − least) / widest", "",
            2},
    Wording{"lesion.plaque_eccentricity",
            "Eccentricity of the plaque, (thickest − thinnest) / thickest", "", 2},
    Wording{"lesion.proximal_mm", "Begins, from the inlet", "mm", 1},
    Wording{"lesion.distal_mm", "Ends, from the inlet", "mm", 1},
    Wording{"lesion.treated_first_mm", "Is treated from, from the inlet", "mm", 1},
    Wording{"lesion.treated_last_mm", "Is treated to, from the inlet", "mm", 1},
    Wording{"lesion.length_mm", "Length", "mm", 1},
    Wording{"lesion.evidence", "Evidence (ln of the odds)", "", 1},
    Wording{"lesion.resolution_mm", "Longest edge of a voxel", "mm", 2},
    Wording{"lesion.listed_count", "Stenoses listed", "", 0},
    Wording{"lesion.mld_below_resolution", "MLD is below a voxel", "", 0},
    Wording{"lesion.stenosis_at_least_percent", "Diameter stenosis is at least", "%", 1},
    Wording{"lesion.segment_mld_mm", "MLD along the whole balloon", "mm", 2},
    Wording{"lesion.segment_mla_mm2", "MLA along the whole balloon", "mm²", 2},
    Wording{"lesion.image_mld_mm", "MLD before the lumen was meshed", "mm", 2},
    Wording{"lesion.image_mla_mm2", "MLA before the lumen was meshed", "mm²", 2},
    Wording{"balloon.nominal_diameter_mm", "Nominal diameter", "mm", 2},
    Wording{"balloon.length_mm", "Length", "mm", 1},
    Wording{"balloon.material", "Material", "", 0},
    Wording{"balloon.peak_pressure_atm", "Peak pressure", "atm", 2},
    Wording{"balloon.peak_diameter_mm", "Diameter at peak", "mm", 2},
    Wording{"balloon.balloon_to_artery_ratio", "Balloon-to-artery ratio", "", 2},
    Wording{"balloon.widening_beside_lesion", "Widening of the vessel beside the lesion, at most",
            "", 2},
    Wording{"balloon.rated_burst_atm", "Rated burst pressure", "atm", 1},
    Wording{"balloon.below_chart_mm", "Diameter below the chart's, in the lesion", "mm", 2},
    Wording{"balloon.elongation_mm", "Elongation", "mm", 2},
    Wording{"balloon.dogboning_percent", "Dogboning at peak, (end − lesion) / end", "%", 1},
    Wording{"balloon.dogboning_max_percent", "Dogboning, most of the inflation", "%", 1},
    Wording{"balloon.kinked", "Kinked", "", 0},
    Wording{"balloon.sharpest_fold_degrees", "Sharpest fold", "°", 0},
    Wording{"peak.mld_mm", "Minimal lumen diameter (MLD), in the lesion", "mm", 2},
    Wording{"peak.mla_mm2", "Minimal lumen area (MLA), in the lesion", "mm²", 2},
    Wording{"peak.diameter_stenosis_percent", "Diameter stenosis", "%", 1},
    Wording{"peak.area_stenosis_percent", "Area stenosis", "%", 1},
    Wording{"peak.lumen_eccentricity", "Eccentricity of the lumen", "", 2},
    Wording{"peak.segment_mld_mm", "MLD along the whole balloon", "mm", 2},
    Wording{"peak.segment_mla_mm2", "MLA along the whole balloon", "mm²", 2},
    Wording{"peak.contact_gap_mm", "Gap between balloon and wall", "mm", 3},
    Wording{"peak.contact_force_n", "Force of the balloon on the wall", "N", 2},
    Wording{"peak.pressed_area_mm2", "Area of wall that the balloon presses", "mm²", 1},
    Wording{"peak.pressed_pressure_median_kpa", "Contact pressure, median of that area", "kPa", 0},
    Wording{"peak.pressed_pressure_p99_kpa", "Contact pressure, 99 % of that area", "kPa", 0},
    Wording{"peak.contact_area_mm2", "Area of vertices that feel any contact (depends on the mesh)",
            "mm²", 1},
    Wording{"peak.contact_pressure_median_kpa", "Pressure over those vertices, median", "kPa", 0},
    Wording{"peak.contact_pressure_p99_kpa", "Pressure over those vertices, 99 %", "kPa", 0},
    Wording{"result.mld_mm", "Minimal lumen diameter (MLD), in the lesion", "mm", 2},
    Wording{"result.mla_mm2", "Minimal lumen area (MLA), in the lesion", "mm²", 2},
    Wording{"result.diameter_stenosis_percent", "Residual diameter stenosis", "%", 1},
    Wording{"result.area_stenosis_percent", "Residual area stenosis", "%", 1},
    Wording{"result.lumen_eccentricity", "Eccentricity of the lumen", "", 2},
    Wording{"result.acute_gain_mm", "Acute gain (MLD after − before)", "mm", 2},
    Wording{"result.recoil_mm", "Recoil (MLD at peak − MLD after)", "mm", 2},
    Wording{"result.recoil_percent", "Recoil, of the lumen at peak", "%", 1},
    Wording{"result.recoil_percent_of_balloon", "Recoil, (balloon − MLD after) / balloon", "%", 1},
    Wording{"result.recoil_percent_of_gain", "Recoil, of the gain at peak", "%", 1},
    Wording{"result.segment_mld_mm", "MLD along the whole balloon", "mm", 2},
    Wording{"result.segment_mla_mm2", "MLA along the whole balloon", "mm²", 2},
    Wording{"result.mld_range_mm", "MLD, of two runs", "mm", 3},
    Wording{"result.acute_gain_range_mm", "Acute gain, of two runs", "mm", 3},
    Wording{"result.recoil_range_percent", "Recoil, of two runs", "%", 1},
    Wording{"flow.reason", "Not told, because", "", 0},
    Wording{"flow.model", "Model", "", 0},
    Wording{"flow.inlet_diameter_mm", "Healthy diameter of the inlet", "mm", 2},
    Wording{"flow.inlet_flow_ml_min", "Healthy flow through the inlet", "mL/min", 0},
    Wording{"flow.aortic_pressure_mmhg", "Pressure at the inlet", "mmHg", 0},
    Wording{"flow.behind_mm", "Measured behind the lesion, from the inlet", "mm", 1},
    Wording{"flow.ffr_before", "FFR behind the lesion, before", "", 2},
    Wording{"flow.ffr_before_range", "within one standard deviation", "", 2},
    Wording{"flow.ffr_after", "FFR behind the lesion, after", "", 2},
    Wording{"flow.ffr_after_range", "within one standard deviation", "", 2},
    Wording{"flow.least_ffr_before", "Least FFR of the tree, before", "", 2},
    Wording{"flow.least_ffr_after", "Least FFR of the tree, after", "", 2},
    Wording{"flow.pressure_drop_before_mmhg", "Pressure drop at the lesion, before", "mmHg", 1},
    Wording{"flow.pressure_drop_after_mmhg", "Pressure drop at the lesion, after", "mmHg", 1},
    Wording{"flow.flow_before_ml_min", "Flow behind the lesion, before", "mL/min", 0},
    Wording{"flow.flow_after_ml_min", "Flow behind the lesion, after", "mL/min", 0},
    Wording{"flow.vessel", "Vessel", "", 0},
    Wording{"flow.least_ffr_before_range", "Least FFR, before, one deviation", "", 2},
    Wording{"flow.least_ffr_after_range", "Least FFR, after, one deviation", "", 2},
    Wording{"flow.pressure_drop_before_range_mmhg", "Pressure drop, before, one deviation", "mmHg",
            1},
    Wording{"flow.pressure_drop_after_range_mmhg", "Pressure drop, after, one deviation", "mmHg",
            1},
    Wording{"flow.flow_before_range_ml_min", "Flow, before, one deviation", "mL/min", 0},
    Wording{"flow.flow_after_range_ml_min", "Flow, after, one deviation", "mL/min", 0},
    Wording{"working_view.label", "Best view", "", 0},
    Wording{"working_view.primary_angle_degrees", "RAO (-) / LAO (+)", "°", 0},
    Wording{"working_view.secondary_angle_degrees", "CAU (-) / CRA (+)", "°", 0},
    Wording{"working_view.foreshortening_percent", "Foreshortening", "%", 1},
    Wording{"working_view.overlap_percent", "Overlap", "%", 1},
    Wording{"working_view.second_label", "Second view", "", 0},
    Wording{"working_view.second_primary_angle_degrees", "its RAO (-) / LAO (+)", "°", 0},
    Wording{"working_view.second_secondary_angle_degrees", "its CAU (-) / CRA (+)", "°", 0},
    Wording{"working_view.second_foreshortening_percent", "its foreshortening", "%", 1},
    Wording{"working_view.second_overlap_percent", "its overlap", "%", 1},
    Wording{"working_view.patient_axes", "The patient's axes", "", 0},
    Wording{"working_view.primary_limit_degrees", "RAO / LAO looked at, up to", "°", 0},
    Wording{"working_view.secondary_limit_degrees", "CAU / CRA looked at, up to", "°", 0},
    Wording{"working_view.reason", "Not told, because", "", 0},
    Wording{"simulation.mean_sweeps", "Sweeps a step, mean", "", 1},
    Wording{"simulation.worst_residual", "Worst residual", "", 3},
    Wording{"simulation.worst_contact_pressure_ratio",
            "Contact pressure (99 %) over the balloon's, worst", "", 2},
    Wording{"simulation.frames_without_air", "Frames without whole air", "", 0},
    Wording{"simulation.air_left_out_percent", "Air left out", "%", 2},
    Wording{"simulation.air_rebuilds", "Air meshes made anew", "", 0},
    Wording{"simulation.air_flips", "Flips of the air mesh", "", 0},
    Wording{"simulation.backend", "Backend", "", 0},
    Wording{"simulation.device", "Device", "", 0},
    Wording{"simulation.frame_count", "Frames", "", 0},
    Wording{"simulation.simulated_s", "Simulated time", "s", 2},
    Wording{"simulation.wall_s", "Computing time", "s", 1},
    Wording{"simulation.frames_per_second", "Frames per second", "1/s", 1},
    Wording{"simulation.real_time_factor", "Simulated / computing time", "", 2},
    Wording{"simulation.max_penetration_mm", "Deepest penetration", "mm", 4},
    Wording{"simulation.inverted_air_tets", "Inverted air tetrahedra, worst frame", "", 0},
    Wording{"simulation.guard", "Second run", "", 0},
    Wording{"mesh.lumen_triangles", "Lumen triangles", "", 0},
    Wording{"mesh.lumen_vertices", "Lumen vertices", "", 0},
    Wording{"mesh.watertight", "Watertight when capped", "", 0},
    Wording{"mesh.self_intersections", "Self-intersections", "", 0},
    Wording{"mesh.min_angle_degrees", "Least angle", "°", 1},
    Wording{"mesh.min_angle_off_rims_degrees", "Least angle, away from the rims", "°", 1},
    Wording{"mesh.min_angle_capped_degrees", "Least angle, with caps", "°", 1},
    Wording{"mesh.triangles_below_20_degrees", "Triangles with an angle under 20°", "", 0},
    Wording{"mesh.triangles_below_20_degrees_at_rims", "of these at the rims", "", 0},
    Wording{"mesh.triangles_below_20_degrees_capped", "with caps", "", 0},
    Wording{"wall.model", "Model", "", 0},
    Wording{"wall.over_strength_mm3", "Volume over its strength", "mm³", 1},
    Wording{"wall.over_strength_percent", "Share over its strength, where the balloon touches", "%",
            1},
    Wording{"mesh.mean_edge_mm", "Mean edge", "mm", 3},
    Wording{"mesh.distance_mean_mm", "Distance to the lumen that was meshed, mean", "mm", 4},
    Wording{"mesh.distance_percentile_95_mm", "Distance to the lumen that was meshed, 95 %", "mm",
            4},
    Wording{"mesh.volume_mm3", "Volume", "mm³", 1},
    Wording{"mesh.volume_change_percent", "Change of volume by meshing", "%", 3},
    Wording{"mesh.tets", "Tetrahedra", "", 0},
    Wording{"mesh.min_dihedral_degrees", "Least dihedral angle", "°", 1},
    Wording{"mesh.max_dihedral_degrees", "Greatest dihedral angle", "°", 1},
    Wording{"run.version", "Version", "", 0},
    Wording{"run.backend", "Backend", "", 0},
    Wording{"run.device", "Device", "", 0},
    Wording{"run.input", "Input", "", 0},
    Wording{"run.input_description", "Input", "", 0},
    Wording{"run.input_kind", "Input kind", "", 0},
    Wording{"run.input_sha256", "Input SHA-256", "", 0},
    Wording{"run.case", "Case", "", 0},
    Wording{"run.program", "Program", "", 0},
    Wording{"stage.status", "Status", "", 0},
    Wording{"stage.seconds", "Time", "s", 1},
    Wording{"stage.peak_memory_mib", "Peak memory", "MiB", 0},
};

/// One listed twice would be two rows.
constexpr bool every_key_is_listed_once() {
  for (std::size_t i = 0; i < kWordings.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (std::string_view(kWordings[i].key) == kWordings[j].key) return false;
  return true;
}
static_assert(every_key_is_listed_once());

constexpr std::array<std::array<const char*, 2>, 8> kGroupTitles{
    {{"lesion", "Lesion, before"},
     {"balloon", "Balloon"},
     {"peak", "Lumen at peak"},
     {"result", "Result, after deflation"},
     {"flow", "Blood flow, estimated"},
     {"working_view", "Working view"},
     {"simulation", "Simulation"},
     {"mesh", "Surface mesh"}}};

ordered_json parse_object(const std::string& text, const char* name) {
  if (text.empty()) return ordered_json::object();
  ordered_json parsed = ordered_json::parse(text, nullptr, false);
  if (!parsed.is_object())
    throw InputError(std::string(name) +
                     " is damaged (not a JSON object). Run the simulation stage again");
  return parsed;
}

const Wording* find_wording(const std::string& key) {
  const auto found = std::find_if(kWordings.begin(), kWordings.end(),
                                  [&](const Wording& w) { return key == w.key; });
  return found == kWordings.end() ? nullptr : &*found;
}

/// A key that has no wording still has its unit at the end, by the naming rules.
const char* unit_of(std::string_view key) {
  constexpr std::array<std::array<const char*, 2>, 10> kUnits{{{"_mm", "mm"},
                                                               {"_mm2", "mm²"},
                                                               {"_mm3", "mm³"},
                                                               {"_percent", "%"},
                                                               {"_atm", "atm"},
                                                               {"_kpa", "kPa"},
                                                               {"_degrees", "°"},
                                                               {"_mmhg", "mmHg"},
                                                               {"_ml_min", "mL/min"},
                                                               {"_s", "s"}}};
  for (const auto& [suffix, unit] : kUnits)
    if (key.ends_with(suffix)) return unit;
  return "";
}

bool is_range(const ordered_json& value) {
  return value.is_array() && value.size() == 2 && value[0].is_number() && value[1].is_number();
}

/// A value as people read it, unescaped.
std::string value_text(const ordered_json& value, int decimals) {
  if (value.is_null()) return "–";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_integer()) return std::to_string(value.get<long long>());
  if (value.is_number()) return formats::fixed_text(value.get<double>(), decimals);
  if (value.is_string()) {
    const std::string words = value.get<std::string>();
    return words.empty() ? "–" : words;
  }
  if (is_range(value))
    return formats::fixed_text(value[0].get<double>(), decimals) + " to " +
           formats::fixed_text(value[1].get<double>(), decimals);
  return value.dump();
}

std::string row(const std::string& prefix, const std::string& key, const ordered_json& value) {
  const Wording* wording = find_wording(prefix + "." + key);
  const std::string label = wording ? wording->label : key;
  const std::string unit = wording ? wording->unit : unit_of(key);
  std::string shown = value_text(value, wording ? wording->decimals : 3);
  if (!unit.empty() && !value.is_null()) shown += (unit == "°" ? "" : " ") + unit;
  return "<tr><th scope=\"row\">" + formats::escape_html(label) + "</th><td>" +
         formats::escape_html(shown) + "</td></tr>";
}

/// Known keys in the order of the wordings, then the others.
std::string rows(const std::string& prefix, const ordered_json& object) {
  std::string out;
  for (const Wording& wording : kWordings) {
    const std::string_view key = wording.key;
    if (!key.starts_with(prefix + ".")) continue;
    const std::string name(key.substr(prefix.size() + 1));
    if (name == "reason" && object.contains(name) && object[name].is_null()) continue;
    if (object.contains(name) && (object[name].is_primitive() || is_range(object[name])))
      out += row(prefix, name, object[name]);
  }
  for (const auto& [key, value] : object.items())
    if (value.is_primitive() && !find_wording(std::string(prefix).append(".").append(key)))
      out += row(prefix, key, value);
  return out;
}

std::string stage_row(const std::string& name, const ordered_json& stage) {
  const auto number = [&](const char* key, int decimals, const char* unit) -> std::string {
    const bool has = stage.contains(key) && stage[key].is_number();
    return "<td>" + (has ? formats::fixed_text(stage[key].get<double>(), decimals) + unit : "–") +
           "</td>";
  };
  return "<tr><th scope=\"row\">" + formats::escape_html(name) + "</th><td>" +
         formats::escape_html(stage.contains("status") ? value_text(stage["status"], 0) : "–") +
         "</td>" + number("seconds", 1, " s") + number("peak_memory_mib", 0, " MiB") + "</tr>";
}

/// The stages in the order in which they run, then any others.
std::string stage_rows(const ordered_json& stages) {
  constexpr std::array kOrder{"reconstruction", "segmentation", "centerline",
                              "meshing",        "simulation",   "report"};
  std::string body =
      "<tr><th scope=\"col\">Stage</th><th scope=\"col\">Status</th><th scope=\"col\">Time</th>"
      "<th scope=\"col\">Peak memory</th></tr>";
  for (const char* name : kOrder)
    if (stages.contains(name) && stages[name].is_object()) body += stage_row(name, stages[name]);
  for (const auto& [name, stage] : stages.items())
    if (stage.is_object() && std::find(kOrder.begin(), kOrder.end(), name) == kOrder.end())
      body += stage_row(name, stage);
  return body;
}

std::string table(const std::string& title, const std::string& body) {
  if (body.empty()) return {};
  return "<div class=\"table\"><h3>" + formats::escape_html(title) + "</h3><table>" + body +
         "</table></div>";
}

}  // namespace

struct Metrics::Content {
  ordered_json root;
};

Metrics::Metrics(const std::string& text)
    : content_(std::make_unique<Content>(Content{parse_object(text, "metrics.json")})) {}
Metrics::~Metrics() = default;
Metrics::Metrics(Metrics&&) noexcept = default;
Metrics& Metrics::operator=(Metrics&&) noexcept = default;

std::optional<double> Metrics::number(const char* group, const char* key) const {
  const auto found = content_->root.find(group);
  if (found == content_->root.end() || !found->is_object()) return std::nullopt;
  const auto value = found->find(key);
  if (value == found->end() || !value->is_number()) return std::nullopt;
  const double number = value->get<double>();
  return std::isfinite(number) ? std::optional<double>(number) : std::nullopt;
}

std::optional<std::array<double, 2>> Metrics::range(const char* group, const char* key) const {
  const auto found = content_->root.find(group);
  if (found == content_->root.end() || !found->is_object()) return std::nullopt;
  const auto value = found->find(key);
  if (value == found->end() || !is_range(*value)) return std::nullopt;
  return std::array{(*value)[0].get<double>(), (*value)[1].get<double>()};
}

std::string Metrics::text(const char* group, const char* key) const {
  const auto found = content_->root.find(group);
  if (found == content_->root.end() || !found->is_object()) return {};
  const auto value = found->find(key);
  return value != found->end() && value->is_string() ? value->get<std::string>() : std::string();
}

std::string Metrics::text(const char* key) const {
  const auto value = content_->root.find(key);
  return value != content_->root.end() && value->is_string() ? value->get<std::string>()
                                                             : std::string();
}

namespace {

/// Of a layered wall, a row a layer.
std::string wall_rows(const ordered_json& wall) {
  std::string body = rows("wall", wall);
  if (!wall.contains("regions") || !wall["regions"].is_object()) return body;
  for (const auto& [layer, told] : wall["regions"].items()) {
    if (!told.is_object()) continue;
    const auto number = [&](const char* key, int decimals) {
      return told.contains(key) ? value_text(told[key], decimals) : std::string("–");
    };
    const auto row = [&](const std::string& what, const std::string& value) {
      body += "<tr><th scope=\"row\">" + what + formats::escape_html(layer) + "</th><td>" +
              formats::escape_html(value) + "</td></tr>";
    };
    const auto quantiles = [&](const std::string& name, const std::string& unit, int decimals) {
      return number((name + "_median" + unit).c_str(), decimals) + "; " +
             number((name + "_p95" + unit).c_str(), decimals) + "; " +
             number((name + "_p99" + unit).c_str(), decimals);
    };
    if (told.contains("pressed_log_strain_median")) {
      row("Stress at the peak under the balloon (median; 95; 99 %), ",
          quantiles("pressed_principal_stress", "_kpa", 0) + " kPa");
      row("Log strain likewise, ", quantiles("pressed_log_strain", "", 2));
    } else {
      row("Stress at the peak (median; 99 %), ",
          number("peak_principal_stress_median_kpa", 0) + "; " +
              number("peak_principal_stress_p99_kpa", 0) + " kPa");
    }
    row("Plastic strain that stays (99 %), ", number("plastic_strain_p99", 2));
  }
  return body;
}

}  // namespace

std::string Metrics::tables() const {
  std::string out;
  if (const std::string status = text("status"); !status.empty())
    out += table("Case", "<tr><th scope=\"row\">Status</th><td>" + formats::escape_html(status) +
                             "</td></tr>");
  for (const auto& [group, title] : kGroupTitles)
    if (content_->root.contains(group) && content_->root[group].is_object())
      out += table(title, rows(group, content_->root[group]));
  if (content_->root.contains("wall") && content_->root["wall"].is_object())
    out += table("Wall, at peak", wall_rows(content_->root["wall"]));
  return out;
}

namespace {

/// A lesion's value, or its bound where the throat is narrower than a voxel: seen, not measured.
std::string lesion_value(const ordered_json& lesion, const Wording& column) {
  const std::string key = column.key;
  if (!lesion.contains(key)) return "–";
  const auto number = [&](const char* name) {
    return lesion.contains(name) && lesion[name].is_number() ? lesion[name].get<double>() : 0.0;
  };
  const auto bound = [&](const char* sign, double value) {
    return sign + formats::fixed_text(value, column.decimals);
  };
  const double voxel = number("resolution_mm"), least = number("stenosis_at_least_percent");
  if (lesion.value("mld_below_resolution", ordered_json()) == true && voxel > 0.0) {
    if (key == "mld_mm") return bound("< ", voxel);
    if (key == "mla_mm2") return bound("< ", 0.25 * units::kPi * voxel * voxel);
    if (key == "diameter_stenosis_percent") return bound("≥ ", least);
    // As the area goes with the square of the diameter.
    if (key == "area_stenosis_percent") return bound("≥ ", least * (2.0 - 0.01 * least));
  }
  return value_text(lesion[key], column.decimals);
}

}  // namespace

std::string lesion_table(const std::string& text) {
  if (text.empty()) return {};
  const ordered_json lesions = ordered_json::parse(text, nullptr, false);
  if (!lesions.is_array())
    throw InputError("lesions.json is damaged (not a JSON array). Run the centerline stage again");
  if (lesions.empty())
    return "<p class=\"sub\">No stenosis is listed. Narrowings in doubt, if there are any, are "
           "among the remarks.</p>\n";
  constexpr std::array kColumns{
      Wording{"centerline_id", "Centreline", "", 0},
      Wording{"abscissa_mm", "From the inlet", "mm", 1},
      Wording{"mld_mm", "MLD", "mm", 2},
      Wording{"reference_diameter_mm", "Reference", "mm", 2},
      Wording{"reference_interpolated_mm", "Reference, interpolated", "mm", 2},
      Wording{"reference_average_mm", "Reference, average", "mm", 2},
      Wording{"diameter_stenosis_percent", "Diameter stenosis", "%", 1},
      Wording{"mla_mm2", "MLA", "mm²", 2},
      Wording{"area_stenosis_percent", "Area stenosis", "%", 1},
      Wording{"length_mm", "Length", "mm", 1},
  };
  std::string body = "<tr><th scope=\"col\">No.</th>";
  for (const Wording& column : kColumns)
    body += "<th scope=\"col\">" + formats::escape_html(column.label) +
            (*column.unit ? " [" + formats::escape_html(column.unit) + "]" : "") + "</th>";
  body += "</tr>";
  for (std::size_t i = 0; i < lesions.size(); ++i) {
    body += "<tr><th scope=\"row\">" + std::to_string(i + 1) + "</th>";
    for (const Wording& column : kColumns)
      body += "<td>" + formats::escape_html(lesion_value(lesions[i], column)) + "</td>";
    body += "</tr>";
  }
  return "<p class=\"sub on-narrow\">The table is wider than the page: move it sideways to see all "
         "columns.</p>\n<div class=\"table wide\"><table>" +
         body +
         "</table></div>\n<p class=\"sub\">Before the lumen was meshed; what is simulated is "
         "measured on its wall.</p>"
         "\n";
}

std::string run_tables(const std::string& text) {
  const ordered_json run = parse_object(text, "run.json");
  ordered_json flat = ordered_json::object();
  for (const auto& [key, value] : run.items()) {
    if (!value.is_object()) flat[key] = value;
    if (value.is_object() && key != "stages")
      for (const auto& [inner, inner_value] : value.items())
        flat[std::string(key).append("_").append(inner)] = inner_value;
  }
  std::string out = table("Run", rows("run", flat));
  if (run.contains("stages") && run["stages"].is_object())
    out += table("Stages", stage_rows(run["stages"]));
  return out;
}

}  // namespace angio::viewer::detail
