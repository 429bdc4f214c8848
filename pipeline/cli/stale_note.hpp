#pragma once

#include <filesystem>

#include "pipeline/stages/reporter.hpp"

namespace angio::pipeline {

/// Where a case's settings or files have changed since its simulation: a note that what is shown of
/// it is the earlier one. Nothing of what is no case, or has no numbers.
void note_if_stale(const std::filesystem::path& case_folder, Reporter& reporter);

}  // namespace angio::pipeline
