#pragma once

#include <filesystem>

#include "core/volume.hpp"

namespace angio::viewer::test {

/// Writes an uncompressed NRRD of float voxels, LPS.
void write_nrrd(const std::filesystem::path& path, const Volume<float>& volume);

/// A case folder as the pipeline leaves it: scan, lumen, centreline, five frames, time series.
void write_case(const std::filesystem::path& folder);

}  // namespace angio::viewer::test
