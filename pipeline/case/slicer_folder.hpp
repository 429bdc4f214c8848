#pragma once

#include <filesystem>
#include <vector>

namespace angio::pipeline {

/// Writes what 3D Slicer opens of a case: lumen.seg.nrrd, the lumen's mask as a segmentation on the
/// volume's grid, and centerlines.vtp, the lines with the point array Radius [mm] beside their own.
/// Each file is written atomically; all is read before the first is written.
///
/// @return the files
/// @throws InputError (66) if the case has no lines, or comes from a surface and has no mask
std::vector<std::filesystem::path> write_slicer_folder(const std::filesystem::path& case_folder,
                                                       const std::filesystem::path& folder);

}  // namespace angio::pipeline
