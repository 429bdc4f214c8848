#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace angio::formats {

using CsvRow = std::vector<std::string>;

/// Rows of a CSV text (RFC 4180: quoted cells may hold commas, line ends and doubled quotes); empty
/// lines are left out.
std::vector<CsvRow> parse_csv(const std::string& text, char separator = ',');

/// A table with a header; every row has a cell for each column.
struct CsvTable {
  std::string file;  ///< for messages
  CsvRow columns;
  std::vector<CsvRow> rows;

  /// A column's numbers; NaN where a cell is empty. @throws InputError if there is no such column,
  /// or a cell holds no finite number
  [[nodiscard]] std::vector<double> numbers(const std::string& column) const;
  /// A column's cells. @throws InputError if there is no such column
  [[nodiscard]] std::vector<std::string> texts(const std::string& column) const;
};

/// @throws InputError naming the file: missing (66), empty, or a row of another length (65)
CsvTable read_csv_table(const std::filesystem::path& file);

/// A cell that keeps its row whole and that no spreadsheet takes for a formula.
std::string csv_cell(std::string text);

}  // namespace angio::formats
