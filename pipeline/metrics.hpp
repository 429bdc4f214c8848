#pragma once

#include <nlohmann/json.hpp>

#include "centerline/centerline.hpp"
#include "pipeline/case_folder.hpp"

namespace angio::pipeline {

/// metrics.json (CONTRACT) from what the stages have left so far; null where it does not apply.
nlohmann::json collect_metrics(const CaseFolder& case_folder, const Config& config,
                               const RunRecord& record);

/// The lesion to treat: the first of find_lesions.
centerline::Lesion chosen_lesion(const CenterlineTree& tree, const Config& config);

/// A JSON file of the case. @throws InputError naming the file if it is missing or damaged
nlohmann::json read_json(const std::filesystem::path& file);

}  // namespace angio::pipeline
