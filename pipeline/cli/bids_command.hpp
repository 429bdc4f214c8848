#pragma once

#include <string>
#include <vector>

#include "pipeline/cli/batch.hpp"
#include "pipeline/cli/shared_options.hpp"

namespace CLI {
class App;
}

namespace angio::pipeline {

/// `angio bids BIDS_DIR OUTPUT_DIR LEVEL`: a batch in the words of a BIDS App (Gorgolewski et al.,
/// "BIDS apps", PLoS Comput Biol 13(3), 2017, e1005209), for engines that call such.
struct BidsArguments {
  std::filesystem::path dataset;
  std::string level;                ///< participant or group
  std::vector<std::string> labels;  ///< of participants, with or without sub-; empty: all
  std::string suffix = "angio";
  std::string keep = "all";
  bool no_validator = false;  ///< angio has none; engines pass the flag
  SharedOptions shared;
  BatchRequest request;
};

void add_bids_command(CLI::App& app, BidsArguments& bids);
int do_bids(BidsArguments& bids);

/// The scans of a dataset as cases: sub-*/[ses-*/]DATATYPE/*_SUFFIX.nii[.gz], by name. A case is
/// named as its file, without the suffix.
///
/// @throws InputError (66) where there is no such folder, no such participant, or no scan
std::vector<BatchCase> bids_cases(const std::filesystem::path& dataset, const std::string& suffix,
                                  const std::vector<std::string>& labels);

}  // namespace angio::pipeline
