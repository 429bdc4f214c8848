#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/stages/stage_files.hpp"

namespace angio::pipeline {

/// What a stage works with beside its settings (a ConfigView): all that it sees is in its key.
struct StageWork {
  const StageFiles& files;    ///< the case's files that it has declared
  const RunRecord& run;       ///< what it may know of the run (StageDefinition::sees)
  std::string input;          ///< segmentation only; empty: take the case's own volume
  std::filesystem::path out;  ///< becomes case/STAGE once the work is done
  Progress progress;

  // What the stage has to say beside its files.
  std::string input_description = {};     ///< for run.json; empty: as it was
  std::string backend = {}, device = {};  ///< the same
  double solver_seconds = 0.0;
  std::map<std::string, double> time_split = {};
  std::vector<std::string> warnings = {};
  /// Why what is in `out` is no result: it is kept for diagnosis, the stage fails. Empty: it is
  /// one.
  std::string failure = {};
};

inline constexpr const char* kPhantomPrefix = "phantom:";

/// What kind of thing INPUT names. @throws InputError (66) if it does not exist, Error (64) for a
/// phantom that there is not
enum class InputKind { volume, surface, phantom };
InputKind input_kind(const std::string& input);
const char* name(InputKind kind);

}  // namespace angio::pipeline
