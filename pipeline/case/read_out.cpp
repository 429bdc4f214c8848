#include "pipeline/case/read_out.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/units.hpp"
#include "pipeline/case/case_status.hpp"
#include "pipeline/case/doubts.hpp"
#include "pipeline/case/input_kind.hpp"

namespace angio::pipeline {
namespace {

using nlohmann::json;

double number(const json& metrics, const char* group, const char* key) {
  return metrics.at(group).at(key).get<double>();
}

bool has_number(const json& metrics, const char* group, const char* key) {
  return metrics.contains(group) && metrics[group].contains(key) && metrics[group][key].is_number();
}

/// " ± 0.02" where the lines carry it.
std::string sd_of(const json& metrics) {
  if (!has_number(metrics, "lesion", "mld_sd_mm")) return {};
  return fmt::format(" ± {:.2f}", number(metrics, "lesion", "mld_sd_mm"));
}

std::string before(const json& metrics, bool is_surface) {
  const bool is_bound = has_number(metrics, "lesion", "stenosis_at_least_percent");
  const std::string width =
      is_bound
          ? fmt::format("narrower than {} of {:.2f} mm{}", is_surface ? "the voxels" : "a voxel",
                        number(metrics, "lesion", "resolution_mm"),
                        is_surface ? " that the surface was made from" : "")
          : fmt::format("minimal lumen diameter {:.2f}{} mm", number(metrics, "lesion", "mld_mm"),
                        sd_of(metrics));
  if (metrics.at("status") == "no_lesion") return "before   " + width + " at the trial place";
  const bool is_counted = has_number(metrics, "lesion", "listed_count");
  const double listed = is_counted ? number(metrics, "lesion", "listed_count") : 0.0;
  const std::string others =
      listed > 1.0 ? fmt::format("; {:.0f} stenoses are listed, this one is looked at", listed)
                   : "";
  return fmt::format("before   {}, {}{:.0f} % stenosis of {:.2f} mm{}", width,
                     is_bound ? "at least " : "",
                     number(metrics, "lesion",
                            is_bound ? "stenosis_at_least_percent" : "diameter_stenosis_percent"),
                     number(metrics, "lesion", "reference_diameter_mm"), others);
}

std::string after(const json& metrics) {
  if (metrics.at("status") == "no_lesion") return "after    no lesion was treated";
  if (metrics.at("status") != "done") return "after    not determined";
  const double residual = number(metrics, "result", "diameter_stenosis_percent");
  const std::string left = std::round(residual) < 0.0
                               ? fmt::format("{:.0f} % wider than the reference", -residual)
                               : fmt::format("{:.0f} % stenosis", std::abs(residual));
  return fmt::format(
      "after    minimal lumen diameter {:.2f} mm, {}, recoil {:.0f} %; balloon of {:.2f} mm at "
      "{:.1f} atm",
      number(metrics, "result", "mld_mm"), left, number(metrics, "result", "recoil_percent"),
      number(metrics, "balloon", "nominal_diameter_mm"),
      number(metrics, "balloon", "peak_pressure_atm"));
}

/// Nothing where no place was looked at.
std::string working_view(const json& metrics) {
  if (!has_number(metrics, "working_view", "foreshortening_percent")) return {};
  const json& view = metrics.at("working_view");
  const bool is_assumed = view.at("patient_axes") == "assumed";
  return fmt::format("view     {}: foreshortening {:.0f} %, overlap {:.0f} %{}",
                     view.at("label").get<std::string>(),
                     view.at("foreshortening_percent").get<double>(),
                     view.at("overlap_percent").get<double>(),
                     is_assumed ? ", if the input's axes are the patient's" : "");
}

/// The warnings: of the result itself, of the lines and stenoses, of the meshes, of the image; what
/// was made of the input comes last.
std::vector<std::string> doubts_of(const RunRecord& record) {
  std::vector<std::string> doubts, done;
  const auto add = [&](Stage stage, bool own) {
    const auto entry = record.stages.find(stage);
    if (entry == record.stages.end()) return;
    for (const std::string& text : entry->second.warnings)
      if (concerns_result(stage, text) == own) (is_of_input(text) ? done : doubts).push_back(text);
  };
  add(Stage::segmentation, true);  // whether it is a vessel at all
  for (const Stage stage :
       {Stage::simulation, Stage::centerline, Stage::meshing, Stage::reconstruction, Stage::report})
    add(stage, true);
  for (const Stage stage : {Stage::simulation, Stage::centerline, Stage::meshing,
                            Stage::segmentation, Stage::reconstruction, Stage::report})
    add(stage, false);
  doubts.insert(doubts.end(), done.begin(), done.end());
  return doubts;
}

/// The first doubt, and how many more there are.
std::string to_doubt(const std::vector<std::string>& doubts) {
  if (doubts.empty()) return "to doubt nothing that was noticed";
  if (doubts.front().starts_with(kRepaired))
    return fmt::format("to doubt nothing that was noticed ({} repair{} in the report)",
                       doubts.size(), doubts.size() == 1 ? "" : "s");
  std::string line = "to doubt " + doubts.front();
  if (doubts.size() > 1) line += fmt::format(" ({} more in the report)", doubts.size() - 1);
  return line;
}

/// Why there is no balloon in the vessel, what would bring one there, and what else is in doubt.
std::vector<std::string> why_untreated(const json& metrics, const RunRecord& record) {
  if (!record.is(Stage::simulation, "skipped") || !metrics.at("status_reason").is_string())
    return {};
  std::vector<std::string> lines{
      "result   none is simulated: " + metrics["status_reason"].get<std::string>(),
      std::string("to try   ") + kToTreatAnyway};
  if (const auto doubts = doubts_of(record); !doubts.empty()) lines.push_back(to_doubt(doubts));
  return lines;
}

}  // namespace

std::vector<std::string> read_out(const json& metrics, const RunRecord& record) {
  const bool was_simulated = has_number(metrics, "lesion", "mld_mm") &&
                             has_number(metrics, "lesion", "diameter_stenosis_percent") &&
                             has_number(metrics, "lesion", "reference_diameter_mm") &&
                             record.is(Stage::simulation, "done") &&
                             metrics.at("status").is_string();
  if (!was_simulated) return why_untreated(metrics, record);
  std::vector<std::string> lines{before(metrics, record.input_kind == name(InputKind::surface)),
                                 after(metrics)};
  const std::string view = working_view(metrics);
  if (!view.empty()) lines.push_back(view);
  std::vector<std::string> doubts = doubts_of(record);
  if (metrics.at("status_reason").is_string())
    doubts.insert(doubts.begin(), metrics["status_reason"].get<std::string>());
  lines.push_back(to_doubt(doubts));
  return lines;
}

}  // namespace angio::pipeline
