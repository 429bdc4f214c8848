#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "centerline/resolution.hpp"
#include "core/volume.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {

/// Of a scan, or of a label map, which shows half as much.
centerline::Resolution resolution_of(const Volume<float>& volume);
/// Of the scan or the surface that the case's lumen was found in.
centerline::Resolution case_resolution(const StageFiles& files);
/// The places that Resolution::narrow_lps_mm is of, for case_resolution.
void write_narrow_places(const std::filesystem::path& file, const std::vector<Vec3>& places);
/// What case_resolution reads.
std::vector<std::string> resolution_files();

}  // namespace angio::pipeline
