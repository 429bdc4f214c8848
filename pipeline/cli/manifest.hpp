#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cli/shared_options.hpp"
#include "pipeline/config/config.hpp"

namespace angio::pipeline {

/// One row of a manifest.
struct BatchCase {
  std::string name;                   ///< letters, digits, '.', '_', '-'; names the case's folder
  std::string input;                  ///< as `angio run` takes it; empty: the case's own files
  std::vector<std::string> settings;  ///< "section.key=value" from the other columns
  std::string preset;                 ///< after the batch's own; empty: none
  std::string balloon;                ///< of the catalogue, instead of the batch's; empty: that one
  std::string input_cell;             ///< the input as the manifest has it
};

/// A case's options: the batch's own, and the row's, which win.
SharedOptions row_options(const SharedOptions& shared, const BatchCase& batch_case);

/// Must the rows' inputs be there? A summary needs none.
enum class InputsAre { needed, not_needed };

/// Reads a manifest as spreadsheets write it: a table with commas or semicolons, in UTF-8 with or
/// without its mark; lines that begin with # are left out. A header names the columns `case`,
/// `input`, and, in any order and number, `preset`, `balloon`, `series` and configuration keys,
/// whose empty cells mean the batch's own. The whole of it is checked: columns, names, values, and
/// that the inputs are there.
///
/// @param shared  the batch's own options, which are right
/// @throws Error with a line for each fault, naming the row; its exit code is the faults' (65, 66,
///         78), or 65 where they differ
std::vector<BatchCase> read_manifest(const std::filesystem::path& file,
                                     const SharedOptions& shared = {},
                                     InputsAre inputs = InputsAre::needed);

}  // namespace angio::pipeline
