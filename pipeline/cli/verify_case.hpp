#pragma once

#include <string>
#include <vector>

#include "pipeline/case/case_folder.hpp"

namespace angio::pipeline {

/// One thing in which a case differs from what its run.json records.
struct Finding {
  std::string kind;   ///< "changed", "missing", "stale", "unfinished", "damaged"
  std::string place;  ///< a file in the case, or a stage
  std::string text;   ///< why
};

struct Verification {
  int file_count = 0;  ///< whose content was compared
  std::vector<Finding> findings;
  std::vector<std::string> notes;  ///< what could not be judged
};

/// Compares a case with its run.json: every file's content, every stage's key. Where the case lies
/// makes no difference, and nothing is written.
/// @throws InputError (66) if the folder is no case; (65) if run.json cannot be read
Verification verify_case(const CaseFolder& case_folder);

}  // namespace angio::pipeline
