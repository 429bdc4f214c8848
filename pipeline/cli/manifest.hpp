#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/config/config.hpp"

namespace angio::pipeline {

/// One row of a manifest.
struct BatchCase {
  std::string name;                   ///< letters, digits, '.', '_', '-'; names the case's folder
  std::string input;                  ///< as `angio run` takes it; empty: the case's own files
  std::vector<std::string> settings;  ///< "section.key=value" from the other columns
};

/// Reads a manifest as spreadsheets write it: a table with commas or semicolons, in UTF-8 with or
/// without its mark; lines that begin with # are left out. A header names the columns `case`,
/// `input`, and any number of configuration keys, whose empty cells mean the default. The whole of
/// it is checked: names, inputs, keys and values.
///
/// @param config  what the rows' settings change
/// @throws InputError (66, 65) or OptionError (78) naming the row
std::vector<BatchCase> read_manifest(const std::filesystem::path& file, const Config& config);

}  // namespace angio::pipeline
