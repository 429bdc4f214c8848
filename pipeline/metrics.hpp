#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "centerline/centerline.hpp"
#include "meshing/lumen_volume.hpp"
#include "meshing/meshing.hpp"
#include "pipeline/case_folder.hpp"

namespace angio::pipeline {

/// metrics.json (CONTRACT) from what the stages have left so far; null where it does not apply.
nlohmann::json collect_metrics(const CaseFolder& case_folder, const Config& config,
                               const RunRecord& record);

/// The lesions of find_lesions in the order in which they are to be treated: the most severe first,
/// but those with a throat narrower than a voxel of the scan last. Their diameter is not measured,
/// and many are but two vessels that touch.
std::vector<centerline::Lesion> lesions_to_treat(const CaseFolder& case_folder,
                                                 const Config& config, const CenterlineTree& tree);

/// metrics.json's mesh part, with more of the surface and, if it was filled, of the tetrahedra.
nlohmann::json mesh_metrics(const meshing::LumenMesh& lumen,
                            const std::optional<meshing::LumenVolume>& volume);
/// A lesion under the names of metrics.json.
nlohmann::json lesion_metrics(const centerline::Lesion& lesion);

/// A JSON file of the case. @throws InputError naming the file if it is missing or damaged
nlohmann::json read_json(const std::filesystem::path& file);

}  // namespace angio::pipeline
