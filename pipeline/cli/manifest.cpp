#include "pipeline/cli/manifest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <regex>
#include <set>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "formats/csv.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/experiments/paper_input.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLongestCell = 4096;  // characters: a path's limit
constexpr std::array<const char*, 5> kColumns = {"case", "input", "preset", "balloon", "series"};

// ---- faults ------------------------------------------------------------------------------------

/// All that is wrong with a manifest.
class Faults {
 public:
  void add(const std::string& where, const Error& error) {
    // What is the command line's fault in `angio run` is the data's here.
    const bool is_usage = error.exit_code() == ExitCode::usage;
    const ExitCode code = is_usage ? ExitCode::bad_data : error.exit_code();
    code_ = lines_.empty() || code_ == code ? code : ExitCode::bad_data;
    lines_.push_back(where + ": " + error.what());
  }
  /// @throws Error if there is one
  void refuse(const fs::path& file) const {
    if (lines_.empty()) return;
    std::string text = lines_.size() == 1
                           ? std::string()
                           : fmt::format("{} has {} faults, so that no case was started:\n",
                                         file.filename().string(), lines_.size());
    for (const std::string& line : lines_) text += line + (&line == &lines_.back() ? "" : "\n");
    throw Error(code_, text);
  }

 private:
  std::vector<std::string> lines_;
  ExitCode code_ = ExitCode::bad_data;
};

// ---- the table ---------------------------------------------------------------------------------

/// A row, and where it stands in the file.
struct ManifestRow {
  std::size_t line = 0;
  formats::CsvRow cells;

  [[nodiscard]] std::string where() const { return fmt::format("row {} of the manifest", line); }
};

struct ManifestTable {
  ManifestRow header;
  std::vector<ManifestRow> rows;
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
  if (std::count(text.begin(), text.end(), '"') % 2 != 0)
    throw InputError(fmt::format(
        "{} has a quotation mark without its partner (all that follows would be one cell). "
        "Write two of them for one within a text",
        file.string()));
  if (text.starts_with(kMark)) text.erase(0, 3);
  // Of old spreadsheets, whose lines end so.
  if (text.find('\n') == std::string::npos) std::replace(text.begin(), text.end(), '\r', '\n');
  return text;
}

/// Semicolons where the spreadsheet's language writes numbers with a comma, or tabs.
char separator_of(const std::string& header_line) {
  const auto has = [&](char c) { return header_line.find(c) != std::string::npos; };
  return has(',') ? ',' : has(';') ? ';' : has('\t') ? '\t' : ',';
}

/// Without the blanks around it; with a point where the spreadsheet's language writes a comma.
std::string clean(const std::string& cell, char separator) {
  const std::size_t begin = cell.find_first_not_of(" \t");
  if (begin == std::string::npos) return {};
  std::string text = cell.substr(begin, cell.find_last_not_of(" \t") + 1 - begin);
  if (separator != ',' && text.size() < 32 &&
      std::regex_match(text, std::regex("[-+]?[0-9]+,[0-9]+")))
    text[text.find(',')] = '.';
  return text;
}

ManifestTable table_of(const fs::path& file) {
  const std::string text = text_of(file);
  std::string kept;
  std::vector<std::size_t> line_of;  // of each row that is kept; a quoted cell keeps to its line
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    const std::string one = text.substr(at, end - at);
    ++line;
    at = end;
    const bool names_separator = kept.empty() && one.starts_with("sep=");  // as Excel writes it
    if (names_separator || one.starts_with('#') ||
        one.find_first_not_of(";,\r\n\t ") == std::string::npos)
      continue;
    kept += one;
    line_of.push_back(line);
  }
  const char separator = separator_of(kept.substr(0, kept.find('\n')));
  std::vector<formats::CsvRow> cells = formats::parse_csv(kept, separator);
  if (cells.size() < 2)
    throw InputError(fmt::format(
        "{} has no cases (a header case,input and a row a case are needed)", file.string()));
  ManifestTable table;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    for (std::string& cell : cells[r]) cell = clean(cell, separator);
    ManifestRow row{r < line_of.size() ? line_of[r] : line, cells[r]};
    if (r == 0) {
      for (std::string& column : row.cells) column = lower_case(column);
      table.header = std::move(row);
    } else {
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

// ---- columns -----------------------------------------------------------------------------------

std::size_t column_of(const formats::CsvRow& header, const std::string& column) {
  return std::size_t(std::find(header.begin(), header.end(), column) - header.begin());
}

/// A column without a name may hold nothing: spreadsheets add such ones.
bool has_cells(const ManifestTable& table, std::size_t column) {
  return std::any_of(table.rows.begin(), table.rows.end(), [&](const ManifestRow& row) {
    return column < row.cells.size() && !row.cells[column].empty();
  });
}

void check_columns(const ManifestTable& table, Faults& faults) {
  const formats::CsvRow& header = table.header.cells;
  Config config;
  std::vector<std::string> known(kColumns.begin(), kColumns.end());
  for (const Setting& setting : settings(config)) known.push_back(setting.key);
  for (const char* column : {"case", "input"})
    if (column_of(header, column) == header.size())
      throw InputError(
          fmt::format("the manifest has no column '{}' (its first row must name the columns "
                      "case,input[,preset,balloon,series,section.key...])",
                      column));
  for (std::size_t c = 0; c < header.size(); ++c) {
    if (header[c].empty() && !has_cells(table, c)) continue;
    if (column_of(header, header[c]) != c)
      faults.add(table.header.where(),
                 InputError(fmt::format("the column '{}' is there twice", header[c])));
    if (std::find(known.begin(), known.end(), header[c]) != known.end()) continue;
    const std::string guess = guess_name(header[c], known);
    faults.add(table.header.where(),
               OptionError(fmt::format(
                   "unknown column '{}'{}. Columns are case, input, preset, balloon, series and "
                   "the keys of `angio run --print-config`; # at its head makes a row a remark",
                   header[c].substr(0, 100),
                   guess.empty() ? "" : fmt::format(" (did you mean {}?)", guess))));
  }
}

// ---- rows --------------------------------------------------------------------------------------

/// Reads the rows, and gathers what is wrong with them.
class Rows {
 public:
  Rows(const fs::path& file, const formats::CsvRow& header, const SharedOptions& shared,
       Faults& faults)
      : folder_(fs::absolute(file).parent_path()),
        header_(header),
        shared_(shared),
        faults_(faults) {
    shared_.threads = 0;  // are no matter of the rows
  }

  BatchCase read(const ManifestRow& row, InputsAre inputs) {
    BatchCase found;
    const auto attempt = [&](const auto& part) {
      try {
        part();
        return true;
      } catch (const Error& error) {
        faults_.add(
            found.name.empty() ? row.where() : fmt::format("{} ({})", row.where(), found.name),
            error);
        return false;
      }
    };
    if (!attempt([&] { check_cells(row); })) return found;
    attempt([&] { found.name = name_of(row); });
    Config config;
    bool is_right = true;
    for (const char* column : {"preset", "balloon"})  // each is blamed for itself
      is_right = attempt([&] {
                   BatchCase one = found;
                   (column[0] == 'p' ? one.preset : one.balloon) = cell(row, column);
                   config = {};
                   apply_options(config, row_options(shared_, one));
                   found = one;
                 }) &&
                 is_right;
    for (const std::string& setting : settings_of(row))
      is_right = attempt([&] {
                   apply_setting(config, setting);
                   found.settings.push_back(setting);
                 }) &&
                 is_right;
    if (is_right) attempt([&] { config.validate(); });
    found.input_cell = cell(row, "input");
    attempt([&] { found.input = input_of(found.input_cell, config, inputs); });
    return found;
  }

 private:
  [[nodiscard]] std::string cell(const ManifestRow& row, const std::string& column) const {
    const std::size_t c = column_of(header_, column);
    return c < std::min(header_.size(), row.cells.size()) ? row.cells[c] : std::string();
  }

  void check_cells(const ManifestRow& row) const {
    for (std::size_t c = header_.size(); c < row.cells.size(); ++c)
      if (!row.cells[c].empty())
        throw InputError(
            fmt::format("it has more cells than the header's {} columns (a text with a separator "
                        "in it needs quotes)",
                        header_.size()));
    for (const std::string& cell : row.cells)
      if (cell.size() > kLongestCell)
        throw InputError(fmt::format("a cell of {} characters (at most {} are taken)", cell.size(),
                                     kLongestCell));
  }

  std::string name_of(const ManifestRow& row) {
    static const std::regex kForm("[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}");
    static const std::regex kTaken("summary.*\\.(csv|html|json)|sheet\\.html|figures|logs");
    std::string name = cell(row, "case");
    const bool is_taken = std::regex_match(name, kTaken);
    if (!std::regex_match(name, kForm) || is_taken)
      throw InputError(fmt::format(
          "{} (it names a folder, beside logs and summary.csv: letters, digits, '.', '_' and '-')",
          name.empty() ? "the case has no name"
                       : fmt::format("'{}' cannot be a case's name", name.substr(0, 100))));
    if (!names_.insert(lower_case(name)).second)
      throw InputError(fmt::format(
          "the case {} is there twice (capitals do not part folders everywhere)", name));
    return name;
  }

  [[nodiscard]] std::vector<std::string> settings_of(const ManifestRow& row) const {
    std::vector<std::string> settings;
    const std::string series = cell(row, "series");
    if (!series.empty()) settings.push_back("input.series=\"" + escaped(series) + "\"");
    for (std::size_t c = 0; c < std::min(header_.size(), row.cells.size()); ++c)
      if (header_[c].find('.') != std::string::npos && !row.cells[c].empty())
        settings.push_back(header_[c] + "=" + row.cells[c]);
    return settings;
  }

  static std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) result += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
    return result;
  }

  [[nodiscard]] std::string input_of(const std::string& cell, const Config& config,
                                     InputsAre inputs) const {
    if (cell.empty() && config.experiment.empty())
      throw InputError("it has no input (give a scan, a surface or phantom:NAME)");
    if (cell.empty()) {
      if (default_input(config).empty())
        throw InputError("it has no input, which this experiment needs");
      return {};
    }
    if (cell.starts_with(kPhantomPrefix) || cell.starts_with('/')) {
      if (inputs == InputsAre::needed) check_input(cell, config);
      return cell;
    }
    std::string path = (folder_ / cell).lexically_normal().string();
    if (inputs == InputsAre::not_needed) return path;
    std::error_code ignored;
    if (!fs::exists(path, ignored))
      throw InputError(
          fmt::format("there is no {} beside the manifest ({}). {}", cell,
                      cell.find('\\') != std::string::npos ? "folders are parted by / here"
                                                           : "paths begin at the manifest's folder",
                      "Check the cell input"),
          ExitCode::no_input);
    check_input(path, config);
    return path;
  }

  static void check_input(const std::string& input, const Config& config) {
    try {
      input_kind(input);
      check_experiment_input(config, input);
    } catch (const fs::filesystem_error& error) {
      throw InputError(fmt::format("its input cannot be read ({})", error.code().message()));
    }
  }

  fs::path folder_;
  const formats::CsvRow& header_;
  SharedOptions shared_;
  Faults& faults_;
  std::set<std::string> names_;
};

}  // namespace

SharedOptions row_options(const SharedOptions& shared, const BatchCase& batch_case) {
  SharedOptions options = shared;
  if (!batch_case.preset.empty()) options.presets.push_back(batch_case.preset);
  if (!batch_case.balloon.empty()) options.balloon = batch_case.balloon;
  options.settings.insert(options.settings.end(), batch_case.settings.begin(),
                          batch_case.settings.end());
  return options;
}

std::vector<BatchCase> read_manifest(const fs::path& file, const SharedOptions& shared,
                                     InputsAre inputs) {
  const ManifestTable table = table_of(file);
  Faults faults;
  check_columns(table, faults);
  faults.refuse(file);  // else every row would have the columns' faults
  Rows rows(file, table.header.cells, shared, faults);
  std::vector<BatchCase> cases;
  for (const ManifestRow& row : table.rows) cases.push_back(rows.read(row, inputs));
  faults.refuse(file);
  return cases;
}

}  // namespace angio::pipeline
