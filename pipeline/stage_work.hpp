#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "pipeline/case_folder.hpp"
#include "pipeline/config.hpp"

namespace angio::pipeline {

/// What a stage works with: the case as it is, and a folder of its own to fill.
struct StageWork {
  const CaseFolder& case_folder;
  const Config& config;
  std::filesystem::path out;  ///< becomes case/STAGE once the work is done
  Progress progress;
  std::string input;  ///< segmentation only; empty: take the case's own volume
  RunRecord& record;  ///< backend, device and the input's description are filled in
  std::vector<std::string> warnings;
  /// Why what is in `out` is no result: it is kept for diagnosis, the stage fails. Empty: it is
  /// one.
  std::string failure;
};

/// The case's files that a stage reads; of those named, the ones that exist.
std::vector<std::string> stage_inputs(Stage stage);

/// Does one stage's work. @throws Error, leaving `out` for the caller to remove
void do_stage(Stage stage, StageWork& work);

/// What kind of thing INPUT names. @throws InputError (66) if it does not exist, Error (64) for a
/// phantom that there is not
enum class InputKind { volume, surface, phantom };
InputKind input_kind(const std::string& input);
const char* name(InputKind kind);

}  // namespace angio::pipeline
