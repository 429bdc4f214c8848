#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cli/manifest.hpp"
#include "pipeline/cli/variants.hpp"
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

/// Writes sweep.csv, sweep.json and, where the first setting is a number, sweep.svg.
void write_sweep(const std::filesystem::path& folder, const std::vector<SweepAxis>& axes,
                 const std::vector<VariantRow>& rows);

/// The table for a terminal.
std::string sweep_table(const std::vector<SweepAxis>& axes, const std::vector<VariantRow>& rows);

}  // namespace angio::pipeline
