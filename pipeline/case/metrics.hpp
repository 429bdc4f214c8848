#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "centerline/resolution.hpp"
#include "meshing/lumen_volume.hpp"
#include "meshing/meshing.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {

/// The case's files that collect_metrics() reads.
std::vector<std::string> metrics_files();

/// metrics.json (docs/contract.md) from what the stages have left so far; null where it does not
/// apply, and where what was left is stale.
/// @param lesion  which lesion is shown before there is a mesh
/// @param computed  parts that are made elsewhere, by their keys: case_flow()'s,
/// case_working_view()'s
nlohmann::json collect_metrics(const StageFiles& files, const centerline::LesionOptions& lesion,
                               const nlohmann::json& computed, const RunRecord& record);

/// The same where no stage has left a number yet.
nlohmann::json empty_metrics();

/// The percent diameter stenosis that is known of a throat whose diameter is not measured: it is no
/// wider than a voxel, or than it seems.
double least_stenosis(double mld_mm, double resolution_mm, double reference_diameter_mm);

/// metrics.json's mesh part, with more of the surface and, if it was filled, of the tetrahedra.
nlohmann::json mesh_metrics(const meshing::LumenMesh& lumen,
                            const std::optional<meshing::LumenVolume>& volume);
/// A lesion under the names of metrics.json. @param path  that it is on
nlohmann::json lesion_metrics(const centerline::Lesion& lesion, const CenterlinePath& path,
                              const centerline::Resolution& resolution);

/// A JSON file of the case. @throws InputError naming the file if it is missing or damaged
nlohmann::json read_json(const std::filesystem::path& file);

}  // namespace angio::pipeline
