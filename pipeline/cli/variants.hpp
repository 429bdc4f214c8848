#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "formats/csv.hpp"
#include "pipeline/cli/batch.hpp"
#include "pipeline/cli/manifest.hpp"
#include "pipeline/cli/shared_options.hpp"
#include "pipeline/config/config.hpp"
#include "viewer/sweep_plot.hpp"

/// A case with other settings: what `angio sweep` and `angio recommend` share.
namespace angio::pipeline {

/// Of one call.
inline constexpr std::size_t kMostVariants = 1000;
inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// Gives a variant the case's finished stages, by hard links where the file system has them: what
/// its settings do not change is not made again. The report stays behind. A variant that is there
/// already is left as it is.
void seed_variant(const std::filesystem::path& base, const std::filesystem::path& variant);

/// What came of a variant. Numbers are those of metrics.json, and none are told where its `status`
/// is not `done`.
struct VariantRow {
  BatchCase variant;
  std::string status;  ///< as in metrics.json; "failed" if the run ended without one
  std::string reason;
  std::vector<double> measures;  ///< as variant_measures(); NaN: none
};

/// A number of metrics.json, and its name in the table.
struct VariantMeasure {
  const char* pointer;
  const char* column;  ///< with its unit, as CSV
  const char* title;   ///< with its unit, for people
};
const std::vector<VariantMeasure>& variant_measures();

VariantRow read_variant(const std::filesystem::path& folder, const BatchCase& variant);

/// A measure of a row by its column.
double measure_of(const VariantRow& row, std::string_view column);

/// Each measure against `x`, a curve for each label, in the order of x, then of the rows.
///
/// @param x, labels  shape [row]
std::vector<viewer::SweepPanel> panels_of(const std::vector<VariantRow>& rows,
                                          const std::vector<double>& x,
                                          const std::vector<std::string>& labels);

/// A variant's value of its setting of that index.
std::string value_of(const BatchCase& variant, std::size_t setting);

/// A number as it stands in a table; empty for NaN.
std::string cell_of(double value);
/// The measures by their columns; null for NaN.
nlohmann::json measures_json(const VariantRow& row);

/// Rows as a CSV file's text; as columns for a terminal, the words to the right.
std::string csv_text(const std::vector<formats::CsvRow>& rows);
std::string aligned_text(const std::vector<formats::CsvRow>& rows);

/// What the commands take.
struct VariantArguments {
  std::filesystem::path base;
  bool reports = false;  ///< make each variant's report, too
  SharedOptions shared;
  BatchRequest request;
};

/// @param otherwise  the folder's name without -o
void add_variant_options(CLI::App& command, VariantArguments& arguments,
                         const std::string& otherwise);

/// The configuration of the case that is varied.
/// @throws InputError (66) if it is no case, or its stages' files were removed
Config base_config(const std::filesystem::path& base);

struct VariantResults {
  int failed = 0;                ///< runs that ended with an error
  std::vector<VariantRow> rows;  ///< shape [variant]
};

/// Runs the variants of a case that are not done yet, each in a folder of its own beside base.toml,
/// the configuration that they change.
///
/// @param config  what the variants' settings change
/// @param verb    the command; without -o the folder is CASE-VERB
/// @throws Error (64) if a variant reads the input in another way; IoError (73) if the folder is a
///         case
VariantResults run_variants(VariantArguments& arguments, const Config& config,
                            const std::vector<BatchCase>& variants, const std::string& verb,
                            Reporter& reporter);

}  // namespace angio::pipeline
