#pragma once

#include <string>

#include "viewer/detail/tables.hpp"

namespace angio::viewer::detail {

/// What a case is, in a line: "Scan: stenosis of 60 % on line 1, 3.00 × 12 mm balloon". It is made
/// of the metrics' numbers alone, so it holds no name. Empty where they tell of no vessel.
///
/// @param input_kind  as ReportContent::input_kind
std::string case_headline(const Metrics& metrics, const std::string& input_kind);

/// A balloon's length [mm] to a tenth, as it is: "12", "16.5".
std::string length_text(double length_mm);

}  // namespace angio::viewer::detail
