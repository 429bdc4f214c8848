#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cli/manifest.hpp"
#include "pipeline/config/config.hpp"

namespace angio::pipeline {

/// A setting and the values that it takes in turn.
struct SweepAxis {
  std::string key;
  std::vector<std::string> values;
};

/// "section.key=a,b,c". @throws Error (64) if there is no key or no value, or a value is there
/// twice
SweepAxis parse_axis(const std::string& text);

/// All combinations, the last axis fastest; a variant is named by its values.
///
/// @param config  of the case that is varied
/// @throws OptionError (78) if a key is unknown, given twice, or does not take a value; Error (64)
///         for more than 1000 variants
std::vector<BatchCase> make_variants(const std::vector<SweepAxis>& axes, const Config& config);

/// Gives a variant the case's finished stages, by hard links where the file system has them: what
/// its settings do not change is not made again. The report stays behind. A variant that is there
/// already is left as it is.
void seed_variant(const std::filesystem::path& base, const std::filesystem::path& variant);

/// What came of a variant. Numbers are those of metrics.json, and none are told where its `status`
/// is not `done`.
struct SweepRow {
  BatchCase variant;
  std::string status;  ///< as in metrics.json; "failed" if the run ended without one
  std::string reason;
  std::vector<double> measures;  ///< as sweep_measures(); NaN: none
};

/// A number of metrics.json, and its name in the table.
struct SweepMeasure {
  const char* pointer;
  const char* column;  ///< with its unit, as CSV
  const char* title;   ///< with its unit, for people
};
const std::vector<SweepMeasure>& sweep_measures();

SweepRow read_variant(const std::filesystem::path& folder, const BatchCase& variant);

/// Writes sweep.csv, sweep.json and, where the first setting is a number, sweep.svg.
void write_sweep(const std::filesystem::path& folder, const std::vector<SweepAxis>& axes,
                 const std::vector<SweepRow>& rows);

/// The table for a terminal.
std::string sweep_table(const std::vector<SweepAxis>& axes, const std::vector<SweepRow>& rows);

}  // namespace angio::pipeline
