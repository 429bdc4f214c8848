#pragma once

#include <nlohmann/json.hpp>

#include "centerline/centerline.hpp"
#include "pipeline/case_folder.hpp"

namespace angio::pipeline {

/// metrics.json (CONTRACT) from what the stages have left so far; null where it does not apply.
nlohmann::json collect_metrics(const CaseFolder& case_folder, const Config& config,
                               const RunRecord& record);

/// A lesion under the names of metrics.json.
nlohmann::json lesion_metrics(const centerline::Lesion& lesion);

/// A JSON file of the case. @throws InputError naming the file if it is missing or damaged
nlohmann::json read_json(const std::filesystem::path& file);

}  // namespace angio::pipeline
