#include "formats/csv.hpp"

#include <cstring>
#include <regex>
#include <utility>

namespace angio::formats {

std::vector<CsvRow> parse_csv(const std::string& text) {
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
    else if (c == ',' && !quoted)
      row.push_back(std::exchange(cell, {}));
    else if (c == '\n' && !quoted)
      end_row();
    else if (c != '\r' || quoted)
      cell += c;
  }
  if (!cell.empty() || !row.empty()) end_row();
  return rows;
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
