#include "pipeline/case/metrics.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/case_status.hpp"
#include "pipeline/case/flow.hpp"
#include "pipeline/case/resolution.hpp"
#include "pipeline/case/throat_sd.hpp"
#include "pipeline/case/working_view.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
using nlohmann::json;
namespace {

json object_of_nulls(std::initializer_list<const char*> keys) {
  json object = json::object();
  for (const char* key : keys) object[key] = nullptr;
  return object;
}

/// 0 stands for "not known" in a lesion.
json positive_or_null(double value) { return value > 0.0 ? json(value) : json(nullptr); }

void add_timing(json& simulation, const RunRecord& record) {
  const StageRecord& stage = record.stages.at(Stage::simulation);
  const double wall_s = stage.solver_seconds;
  if (wall_s <= 0.0 || !simulation["frame_count"].is_number()) return;
  simulation["wall_s"] = wall_s;
  simulation["time_split_s"] = stage.time_split;
  simulation["frames_per_second"] = simulation["frame_count"].get<double>() / wall_s;
  simulation["real_time_factor"] = simulation["simulated_s"].get<double>() / wall_s;
}

}  // namespace

json empty_metrics() {
  return {
      {"status", nullptr},
      {"status_reason", nullptr},
      {"lesion",
       object_of_nulls({"centerline_id", "abscissa_mm", "mld_mm", "mld_sd_mm", "mla_mm2",
                        "reference_diameter_mm", "reference_rule", "diameter_stenosis_percent",
                        "length_mm", "lumen_eccentricity", "plaque_eccentricity", "listed_count"})},
      {"balloon",
       object_of_nulls({"nominal_diameter_mm", "length_mm", "material", "peak_pressure_atm",
                        "peak_diameter_mm", "balloon_to_artery_ratio", "widening_beside_lesion",
                        "elongation_mm", "below_chart_mm", "rated_burst_atm", "kinked",
                        "sharpest_fold_degrees", "dogboning_percent", "dogboning_max_percent"})},
      {"result",
       object_of_nulls({"mld_mm", "mla_mm2", "diameter_stenosis_percent", "acute_gain_mm",
                        "recoil_mm", "recoil_percent", "segment_mld_mm", "segment_mla_mm2",
                        "mld_range_mm", "acute_gain_range_mm", "recoil_range_percent",
                        "area_stenosis_percent", "lumen_eccentricity", "recoil_percent_of_balloon",
                        "recoil_percent_of_gain"})},
      {"peak",
       object_of_nulls({"mld_mm", "mla_mm2", "diameter_stenosis_percent", "segment_mld_mm",
                        "segment_mla_mm2", "contact_gap_mm", "area_stenosis_percent",
                        "lumen_eccentricity", "contact_area_mm2", "contact_pressure_median_kpa",
                        "contact_pressure_p99_kpa", "contact_force_n", "pressed_area_mm2",
                        "pressed_pressure_median_kpa", "pressed_pressure_p99_kpa"})},
      {"flow", no_flow()},
      {"working_view", no_working_view()},
      {"simulation", object_of_nulls({"backend", "device", "frame_count", "simulated_s", "wall_s",
                                      "frames_per_second", "real_time_factor", "max_penetration_mm",
                                      "inverted_air_tets", "guard"})},
      {"mesh", object_of_nulls({"lumen_triangles", "lumen_vertices", "watertight",
                                "self_intersections", "min_angle_degrees"})}};
}

json read_json(const std::filesystem::path& file) {
  try {
    return json::parse(read_text(file));
  } catch (const json::exception&) {
    throw InputError(
        fmt::format("{} is damaged (not the JSON that this program writes). Run that "
                    "stage again, or add --force",
                    file.string()));
  }
}

json mesh_metrics(const meshing::LumenMesh& lumen,
                  const std::optional<meshing::LumenVolume>& volume) {
  const meshing::LumenQuality& quality = lumen.quality;
  json mesh = {{"lumen_triangles", lumen.open.triangles.size()},
               {"lumen_vertices", lumen.open.vertices.size()},
               {"watertight", lumen.watertight},
               {"self_intersections", lumen.self_intersection_count},
               {"min_angle_degrees", lumen.min_angle_degrees},
               {"min_angle_off_rims_degrees", quality.min_angle_off_rims_degrees},
               {"min_angle_capped_degrees", lumen.capped_min_angle_degrees},
               {"triangles_below_20_degrees", quality.below_20_degrees},
               {"triangles_below_20_degrees_at_rims", quality.below_20_degrees_at_rims},
               {"triangles_below_20_degrees_capped", lumen.capped_below_20_degrees},
               {"mean_edge_mm", quality.edge_mean_mm},
               {"distance_mean_mm", quality.distance_mean_mm},
               {"distance_percentile_95_mm", quality.distance_percentile_95_mm},
               {"volume_mm3", quality.volume_mm3},
               {"volume_change_percent", quality.volume_change_percent},
               {"tets", nullptr},
               {"min_dihedral_degrees", nullptr},
               {"max_dihedral_degrees", nullptr}};
  if (volume) {
    mesh["tets"] = volume->mesh.tets.size();
    mesh["min_dihedral_degrees"] = volume->min_dihedral_degrees;
    mesh["max_dihedral_degrees"] = volume->max_dihedral_degrees;
  }
  return mesh;
}

double least_stenosis(double mld_mm, double resolution_mm, double reference_diameter_mm) {
  return std::max(0.0, 100.0 * (1.0 - std::max(mld_mm, resolution_mm) / reference_diameter_mm));
}

json lesion_metrics(const centerline::Lesion& lesion, const CenterlinePath& path,
                    const centerline::Resolution& resolution) {
  const bool is_unmeasured = centerline::is_unmeasured(lesion, path, resolution);
  const json at_least =
      is_unmeasured
          ? json(least_stenosis(lesion.mld_mm, resolution.longest_mm, lesion.reference_diameter_mm))
          : json(nullptr);
  return {{"centerline_id", lesion.path_id},
          {"abscissa_mm", lesion.abscissa_mm},
          {"mld_mm", lesion.mld_mm},
          {"mla_mm2", lesion.mla_mm2},
          {"resolution_mm", positive_or_null(resolution.longest_mm)},
          {"mld_below_resolution", is_unmeasured},
          {"stenosis_at_least_percent", at_least},
          {"image_mld_mm", lesion.mld_mm},
          {"image_mla_mm2", lesion.mla_mm2},
          {"reference_diameter_mm", lesion.reference_diameter_mm},
          {"reference_rule", lesion.reference_rule},
          {"reference_tree_mm", positive_or_null(lesion.reference_tree_mm)},
          {"reference_interpolated_mm", positive_or_null(lesion.reference_interpolated_mm)},
          {"reference_average_mm", positive_or_null(lesion.reference_average_mm)},
          {"reference_proximal_mm", positive_or_null(lesion.reference_proximal_mm)},
          {"reference_distal_mm", positive_or_null(lesion.reference_distal_mm)},
          {"widest_beside_mm", positive_or_null(lesion.widest_beside_mm)},
          {"beside_throat_mm", positive_or_null(lesion.beside_throat_mm)},
          {"diameter_stenosis_percent", lesion.diameter_stenosis_percent},
          {"area_stenosis_percent", lesion.area_stenosis_percent},
          {"proximal_mm", lesion.proximal_mm},
          {"distal_mm", lesion.distal_mm},
          {"length_mm", lesion.length_mm},
          {"evidence", positive_or_null(lesion.evidence)}};
}

std::vector<std::string> metrics_files() {
  std::vector<std::string> files = resolution_files();
  files.insert(files.end(),
               {file::kFittedLines, file::kCenterlines, file::kLesions, file::kNarrowedLumen,
                file::kPlacement, file::kSummary, file::kDiagnosis, file::kQuality});
  return files;
}

namespace {

/// The lumen of the wall may be narrower than the image's: what is below a voxel is not measured.
void mark_unmeasured(json& lesion) {
  const json &resolution = lesion["resolution_mm"], &mld = lesion["mld_mm"];
  if (!resolution.is_number() || !mld.is_number() || mld >= resolution) return;
  lesion["mld_below_resolution"] = true;
  lesion["stenosis_at_least_percent"] =
      least_stenosis(mld.get<double>(), resolution.get<double>(),
                     lesion.at("reference_diameter_mm").get<double>());
}

/// Everything but the standard deviation of the throat.
json measured_metrics(const StageFiles& files, const centerline::LesionOptions& lesion,
                      const json& computed, const RunRecord& record) {
  json metrics = empty_metrics();
  metrics.update(computed);
  const bool is_simulated = record.is(Stage::simulation, "done");
  const CaseStatus status = case_status(files, record);
  if (!status.status.empty()) metrics["status"] = status.status;
  if (!status.reason.empty()) metrics["status_reason"] = status.reason;
  if (!record.is(Stage::centerline, "done")) return metrics;
  if (files.exists(file::kLesions))
    metrics["lesion"]["listed_count"] = read_json(files.path(file::kLesions)).size();
  if (!record.is(Stage::meshing, "done")) {
    const CenterlineTree tree = read_centerlines(files.path(file::kCenterlines));
    const centerline::Resolution resolution = case_resolution(files);
    const auto lesions =
        centerline::find_lesions(tree, centerline::lesion_options(lesion, resolution));
    metrics["lesion"].update(
        lesion_metrics(lesions.front(), path_of(tree, lesions.front().path_id), resolution));
    return metrics;
  }
  const json placement = read_json(files.path(file::kPlacement));
  metrics["lesion"].update(placement.at("lesion"));
  metrics["mesh"].update(placement.at("mesh"));
  if (placement.contains("balloon")) metrics["balloon"].update(placement.at("balloon"));
  if (record.is(Stage::simulation, "failed") &&
      record.stages.at(Stage::simulation).outputs.contains(file::kDiagnosis)) {
    metrics["simulation"].update(read_json(files.path(file::kDiagnosis)).at("simulation"));
    add_timing(metrics["simulation"], record);
  }
  if (!is_simulated || !placement.contains("balloon")) return metrics;
  const json summary = read_json(files.path(file::kSummary));
  metrics["balloon"].update(summary.at("balloon"));
  for (const char* group : {"lesion", "peak", "result"}) metrics[group].update(summary.at(group));
  mark_unmeasured(metrics["lesion"]);
  metrics["simulation"].update(summary.at("simulation"));
  if (summary.contains("wall")) metrics["wall"] = summary.at("wall");
  add_timing(metrics["simulation"], record);
  return metrics;
}

}  // namespace

json collect_metrics(const StageFiles& files, const centerline::LesionOptions& lesion,
                     const json& computed, const RunRecord& record) {
  json metrics = measured_metrics(files, lesion, computed, record);
  json& measured = metrics["lesion"];
  if (!record.is(Stage::reconstruction, "done") || !measured["abscissa_mm"].is_number())
    return metrics;
  const CenterlineTree tree = read_centerlines(files.path(file::kCenterlines));
  const CenterlinePath& path = path_of(tree, measured["centerline_id"].get<int>());
  if (const auto sd = throat_sd(files, sample(path, measured["abscissa_mm"].get<double>()).point))
    measured["mld_sd_mm"] = *sd;
  return metrics;
}

}  // namespace angio::pipeline
