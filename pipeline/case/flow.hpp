#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "centerline/flow/flow.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/case/stage_files.hpp"
#include "pipeline/config/config.hpp"

namespace angio::pipeline {

/// Along the treated line. All arrays have shape [point of the line].
struct PullBack {
  std::vector<double> diameter_mm;  ///< of a circle as large as the lumen
  std::vector<double> pressure_mmhg;
  std::vector<centerline::Estimate> ffr;
};

struct CaseFlow {
  nlohmann::json metrics;           ///< `flow` of metrics.json
  std::vector<double> abscissa_mm;  ///< of the treated line's points; empty: nothing is told
  PullBack before;
  std::optional<PullBack> after;  ///< only of what was simulated
};

/// What case_flow() reads, but for case_status().
std::vector<std::string> flow_files();

/// `flow` of metrics.json, all null. @param reason  why
nlohmann::json no_flow(const std::string& reason = {});

/// Fractional flow reserve of the case: the pressure behind the lesion over that at the inlet.
///
/// Before, the lumen is the lines' and, along the balloon, the simulated wall's; after, there the
/// wall's after deflation (lumen_profile.csv). "Behind the lesion" is two reference diameters
/// behind its distal edge, where blood no longer shoots out of it. A trunk that is over 6 mm wide
/// where it is healthy is no coronary artery (a left main stem: 4.5 +- 0.5 mm, Dodge et al.,
/// Circulation 86, 1992, doi:10.1161/01.CIR.86.1.232); nothing is told of it.
///
/// The ratio is called fractional flow reserve, and 0.80 its threshold, in coronary arteries: both
/// were measured there. `vessel` is "coronary" where the user or the input says so (DICOM's body
/// part; the phantoms are of coronary arteries), otherwise "other": of a vessel of the brain, say,
/// the same numbers are a ratio of pressures in a vessel that is dilated as a coronary one.
CaseFlow case_flow(const StageFiles& files, const centerline::FlowOptions& options,
                   FlowVessel vessel, const RunRecord& record);

/// flow.csv: a row for each point of the treated line.
std::string flow_csv(const CaseFlow& flow);

}  // namespace angio::pipeline
