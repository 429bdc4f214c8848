#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/cli/batch_outcome.hpp"

namespace angio::pipeline {

/// A case in a batch's summary.
struct SummaryCase {
  std::string name;
  Outcome outcome;
  nlohmann::json metrics;             ///< metrics.json of one that is done; else null
  std::string case_status;            ///< the case's own
  std::string reason;                 ///< why one of them is not `done`
  std::string input_sha256, version;  ///< of run.json; empty: there is none
  std::vector<std::string> warnings;  ///< of all stages
  double seconds = 0.0;               ///< of all stages
  double peak_memory_mib = 0.0;
};

/// A measure that people compare cases by.
struct SummaryMeasure {
  const char* pointer;  ///< in metrics.json
  const char* title;
  const char* unit;
  int decimals;  ///< shown, as in the report
};
const std::vector<SummaryMeasure>& summary_measures();

/// What metrics.json has at a pointer; null where the case has none.
nlohmann::json value_at(const SummaryCase& one, const char* pointer);

/// The summary as a page that needs nothing but itself and the cases' pictures: sorted by a click
/// on a column's head, filtered by words and status; reasons beside the names, thumbnails, how each
/// measure is spread, links to reports and logs.
std::string summary_page(const std::filesystem::path& folder,
                         const std::vector<SummaryCase>& cases);

/// All cases on one page, for the eye: contour, tree and balloon of each.
std::string quality_page(const std::filesystem::path& folder,
                         const std::vector<SummaryCase>& cases);

/// How a measure is spread over the cases with a stenosis and a result, as SVG: a histogram, of
/// fewer than eight cases a dot for each; empty where fewer than two have it.
std::string spread_figure(const std::vector<SummaryCase>& cases, const SummaryMeasure& measure);

}  // namespace angio::pipeline
