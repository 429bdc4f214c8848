#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "dicom/measurement_report.hpp"

namespace angio::pipeline {

/// The numbers of metrics.json as coded groups: the lesion before, the balloon and the lumen at
/// peak, the lumen after, the blood flow. A number that is null is left out, and a group without
/// numbers; of a case without a stenosis the first group is its narrowest place's. Peak, result and
/// flow afterwards are told only of a case whose status is `done` or `no_lesion`.
///
/// Terms are DICOM's own (PS3.16: TID 3213 and following, quantitative arterial analysis; CID 3651,
/// phases of a catheterization) where it has them, else of the scheme dicom::kPrivateScheme. A flow
/// that is not a coronary artery's is told as a ratio of pressures, not as fractional flow reserve.
std::vector<dicom::MeasurementGroup> measurement_groups(const nlohmann::json& metrics);

}  // namespace angio::pipeline
