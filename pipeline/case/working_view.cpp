#include "pipeline/case/working_view.hpp"

#include <algorithm>
#include <cmath>

#include "formats/case_file.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/metrics.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
using nlohmann::json;
namespace {

void put(json& metrics, const std::string& which, const angiogram::SeenSegment& view) {
  metrics[which + "primary_angle_degrees"] = view.angles.primary_degrees;
  metrics[which + "secondary_angle_degrees"] = view.angles.secondary_degrees;
  metrics[which + "label"] = angiogram::c_arm_label(view.angles);
  metrics[which + "foreshortening_percent"] = view.foreshortening_percent;
  metrics[which + "overlap_percent"] = view.overlap_percent;
}

bool names_no_patient_space(const StageFiles& files, const RunRecord& record) {
  if (has_surface_input(files)) return true;
  const auto stage = record.stages.find(Stage::segmentation);
  if (stage == record.stages.end()) return false;
  const auto& warnings = stage->second.warnings;
  return std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning.find(segmentation::kNoPatientSpace) != std::string::npos;
  });
}

/// The wall's vertices within half the radius of the section at an abscissa.
std::vector<Vec3> wall_near(const TriangleMesh& lumen, const CenterlineSample& at) {
  constexpr double kSlab = 0.5, kAround = 3.0;  // radii
  std::vector<Vec3> points;
  for (const Vec3& p : lumen.vertices) {
    const Vec3 away = p - at.point;
    if (std::abs(dot(away, at.tangent)) < kSlab * at.equivalent_radius &&
        norm(away) < kAround * at.equivalent_radius)
      points.push_back(p);
  }
  return points;
}

angiogram::ViewedSegment lesion_segment(const CenterlineTree& tree, const TriangleMesh& lumen,
                                        const json& lesion) {
  const CenterlinePath& line = path_of(tree, lesion.at("centerline_id").get<int>());
  const auto number = [&](const char* key) { return lesion.at(key).get<double>(); };
  const auto path = std::size_t(&line - tree.paths.data());
  const CenterlineSample narrowest = sample(line, number("abscissa_mm"));
  angiogram::ViewedSegment segment{path, number("proximal_mm"), number("distal_mm"),
                                   wall_near(lumen, narrowest), narrowest.tangent};
  if (segment.first_mm < segment.last_mm) return segment;
  const double reach = std::max(number("reference_diameter_mm"), 1.0);
  segment.first_mm = number("abscissa_mm") - reach;
  segment.last_mm = number("abscissa_mm") + reach;
  return segment;
}

}  // namespace

std::vector<std::string> working_view_files() {
  return {file::kCenterlines, file::kPlacement, file::kGivenLumen, file::kLumen};
}

json no_working_view(const std::string& reason) {
  json metrics = json::object();
  metrics["reason"] = reason.empty() ? json(nullptr) : json(reason);
  for (const std::string which : {"", "second_"})
    for (const char* key : {"primary_angle_degrees", "secondary_angle_degrees", "label",
                            "foreshortening_percent", "overlap_percent"})
      metrics[which + key] = nullptr;
  for (const char* key : {"primary_limit_degrees", "secondary_limit_degrees", "patient_axes"})
    metrics[key] = nullptr;
  return metrics;
}

CaseWorkingView case_working_view(const StageFiles& files,
                                  const angiogram::WorkingViewOptions& options,
                                  const RunRecord& record) {
  if (!record.is(Stage::centerline, "done") || !record.is(Stage::meshing, "done"))
    return {no_working_view(), std::nullopt};
  const CenterlineTree tree = read_centerlines(files.path(file::kCenterlines));
  const json placement = read_json(files.path(file::kPlacement));
  const TriangleMesh lumen = files.exists(file::kLumen) ? read_open_lumen(files) : TriangleMesh{};
  CaseWorkingView found{no_working_view(),
                        angiogram::find_working_view(
                            tree, lesion_segment(tree, lumen, placement.at("lesion")), options)};
  put(found.metrics, "", found.view->best);
  if (found.view->has_second) put(found.metrics, "second_", found.view->second);
  found.metrics["primary_limit_degrees"] = options.primary_limit_degrees;
  found.metrics["secondary_limit_degrees"] = options.secondary_limit_degrees;
  const bool is_assumed = names_no_patient_space(files, record);
  found.metrics["patient_axes"] = is_assumed ? "assumed" : "stated";
  if (is_assumed)
    found.metrics["reason"] =
        "the input does not say how it lies in the patient: its axes are taken as the patient's";
  return found;
}

}  // namespace angio::pipeline
