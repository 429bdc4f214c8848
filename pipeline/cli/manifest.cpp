#include "pipeline/cli/manifest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <set>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "pipeline/case/input_kind.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLongestCell = 4096;  // characters: a path's limit

/// A row, and where it stands in the file.
struct ManifestRow {
  std::size_t line = 0;
  formats::CsvRow cells;

  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError(fmt::format("row {} of the manifest: {}", line, why));
  }
};

std::string text_of(const fs::path& file) {
  constexpr const char* kMark = "\xEF\xBB\xBF";
  if (!fs::exists(file))
    throw InputError(fmt::format("there is no {} (no such manifest)", file.string()),
                     ExitCode::no_input);
  if (!fs::is_regular_file(file))
    throw InputError(fmt::format("{} is no file. Give a CSV manifest", file.string()));
  std::string text = read_text(file);
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    throw InputError(fmt::format("{} is in UTF-16. Save it as \"CSV UTF-8\"", file.string()));
  return text.starts_with(kMark) ? text.substr(3) : text;
}

/// Semicolons where the spreadsheet's language writes numbers with a comma.
char separator_of(const std::string& header_line) {
  return header_line.find(';') != std::string::npos && header_line.find(',') == std::string::npos
             ? ';'
             : ',';
}

std::vector<ManifestRow> rows_of(const fs::path& file) {
  const std::string text = text_of(file);
  std::string kept;
  std::vector<std::size_t> line_of;  // of each row that is kept; a quoted cell keeps to its line
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    const std::string one = text.substr(at, end - at);
    ++line;
    at = end;
    if (one.starts_with('#') || one.find_first_not_of(";,\r\n\t ") == std::string::npos) continue;
    kept += one;
    line_of.push_back(line);
  }
  const auto cells = formats::parse_csv(kept, separator_of(kept.substr(0, kept.find('\n'))));
  std::vector<ManifestRow> rows;
  for (std::size_t r = 0; r < cells.size(); ++r)
    rows.push_back({r < line_of.size() ? line_of[r] : line, cells[r]});
  if (rows.size() < 2)
    throw InputError(fmt::format(
        "{} has no cases (a header case,input and a row a case are needed)", file.string()));
  return rows;
}

std::size_t column_of(const formats::CsvRow& header, const char* column) {
  const auto found = std::find(header.begin(), header.end(), column);
  if (found == header.end())
    throw InputError(
        fmt::format("the manifest has no column '{}' (its first row must name the "
                    "columns case,input[,section.key...])",
                    column));
  return std::size_t(found - header.begin());
}

void check_cells(const ManifestRow& row, const formats::CsvRow& header) {
  for (std::size_t c = header.size(); c < row.cells.size(); ++c)
    if (!row.cells[c].empty())
      row.refuse(
          fmt::format("it has more cells than the header's {} columns (a text with a "
                      "separator in it needs quotes)",
                      header.size()));
  for (const std::string& cell : row.cells)
    if (cell.size() > kLongestCell)
      row.refuse(
          fmt::format("a cell of {} characters (at most {} are taken)", cell.size(), kLongestCell));
}

std::vector<std::string> settings_of(const ManifestRow& row, const formats::CsvRow& header,
                                     Config config) {
  std::vector<std::string> settings;
  for (std::size_t c = 0; c < std::min(header.size(), row.cells.size()); ++c) {
    if (header[c] == "case" || header[c] == "input" || row.cells[c].empty()) continue;
    settings.push_back(header[c] + "=" + row.cells[c]);
    try {
      apply_setting(config, settings.back());
    } catch (const Error& error) {
      throw Error(error.exit_code(),
                  fmt::format("row {} of the manifest: {}", row.line, error.what()));
    }
  }
  return settings;
}

/// @throws Error naming the row if there is none, or nothing lies there
std::string input_of(const ManifestRow& row, const std::string& cell, const fs::path& manifest) {
  if (cell.empty()) row.refuse("it has no input (give a scan, a surface or phantom:NAME)");
  const bool is_path = !cell.starts_with(kPhantomPrefix) && fs::path(cell).is_relative();
  return is_path ? (fs::absolute(manifest).parent_path() / cell).string() : cell;
}

}  // namespace

std::vector<BatchCase> read_manifest(const fs::path& file, const Config& config) {
  const std::vector<ManifestRow> rows = rows_of(file);
  const formats::CsvRow& header = rows[0].cells;
  const std::size_t name_column = column_of(header, "case");
  const std::size_t input_column = column_of(header, "input");
  const std::regex name_form("[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}");
  std::vector<BatchCase> cases;
  std::set<std::string> names;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    const ManifestRow& row = rows[r];
    check_cells(row, header);
    if (row.cells.size() <= std::max(name_column, input_column)) row.refuse("it is too short");
    const std::string& name = row.cells[name_column];
    if (!std::regex_match(name, name_form) || name == "logs")
      row.refuse("a case's name is made of letters, digits, '.', '_' and '-' (it names a folder)");
    if (!names.insert(name).second) row.refuse(fmt::format("the case {} is there twice", name));
    cases.push_back(
        {name, input_of(row, row.cells[input_column], file), settings_of(row, header, config)});
  }
  return cases;
}

}  // namespace angio::pipeline
