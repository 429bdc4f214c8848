#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/case/case_folder.hpp"

namespace angio::pipeline {

/// What a person is told of a case when its run has ended: the lesion before, the lumen after, the
/// C-arm's best view, and what to doubt. The numbers are those of metrics.json; of a result that is
/// none there is none.
///
/// @param metrics  metrics.json (docs/contract.md)
/// @param record   whose stages have their warnings
/// @return three lines, four where there is a view; where there was nothing to simulate, why, and
///         what to try; none before that is known
std::vector<std::string> read_out(const nlohmann::json& metrics, const RunRecord& record);

}  // namespace angio::pipeline
