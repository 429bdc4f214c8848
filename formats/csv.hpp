#pragma once

#include <string>
#include <vector>

namespace angio::formats {

using CsvRow = std::vector<std::string>;

/// Rows of a CSV text (RFC 4180: quoted cells may hold commas, line ends and doubled quotes); empty
/// lines are left out.
std::vector<CsvRow> parse_csv(const std::string& text);

/// A cell that keeps its row whole and that no spreadsheet takes for a formula.
std::string csv_cell(std::string text);

}  // namespace angio::formats
