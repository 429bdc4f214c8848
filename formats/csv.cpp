#include "formats/csv.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <regex>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/tokens.hpp"

namespace angio::formats {

std::vector<CsvRow> parse_csv(const std::string& text, char separator) {
  std::vector<CsvRow> rows;
  CsvRow row;
  std::string cell;
  bool quoted = false;
  const auto end_row = [&] {
    row.push_back(std::move(cell));
    cell.clear();
    if (row.size() > 1 || !row[0].empty()) rows.push_back(std::move(row));
    row.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"')
      cell += text[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == separator && !quoted)
      row.push_back(std::exchange(cell, {}));
    else if (c == '\n' && !quoted)
      end_row();
    else if (c != '\r' || quoted)
      cell += c;
  }
  if (!cell.empty() || !row.empty()) end_row();
  return rows;
}

CsvTable read_csv_table(const std::filesystem::path& file) {
  CsvTable table{file.filename().string(), {}, parse_csv(read_text(file))};
  const std::string advice = ". Run the stage that writes it again";
  if (table.rows.empty()) throw InputError(table.file + " is empty" + advice);
  table.columns = std::move(table.rows.front());
  table.rows.erase(table.rows.begin());
  for (std::size_t r = 0; r < table.rows.size(); ++r)
    if (table.rows[r].size() != table.columns.size())
      throw InputError(table.file + ": row " + std::to_string(r + 1) + " has " +
                       std::to_string(table.rows[r].size()) + " cells, the header " +
                       std::to_string(table.columns.size()) +
                       " (the file was changed or cut short)" + advice);
  return table;
}

std::vector<std::string> CsvTable::texts(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end())
    throw InputError(file + " has no column " + column + ". Run the stage that writes it again");
  const auto c = std::size_t(found - columns.begin());
  std::vector<std::string> cells;
  for (const CsvRow& row : rows) cells.push_back(row[c]);
  return cells;
}

std::vector<double> CsvTable::numbers(const std::string& column) const {
  const std::vector<std::string> cells = texts(column);
  std::vector<double> values;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    const auto number = cells[r].empty() ? std::numeric_limits<double>::quiet_NaN()
                                         : parse_number<double>(cells[r]);
    if (!number || std::isinf(*number))
      throw InputError(file + ": row " + std::to_string(r + 1) + ", column " + column +
                       " is no number (the file was changed or is damaged). Run the stage that "
                       "writes it again");
    values.push_back(*number);
  }
  return values;
}

std::string csv_cell(std::string text) {
  const bool is_number = std::regex_match(text, std::regex(R"(-?[0-9.]+(e-?[0-9]+)?)"));
  if (!text.empty() && !is_number && std::strchr("=+-@\t\r", text[0]) != nullptr) text = "'" + text;
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

}  // namespace angio::formats
