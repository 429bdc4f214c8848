#pragma once

#include <string>
#include <vector>

#include "centerline/resolution.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {

/// Of the scan or the surface that the case's lumen was found in.
centerline::Resolution case_resolution(const StageFiles& files);
/// What that reads.
std::vector<std::string> resolution_files();

}  // namespace angio::pipeline
