#pragma once

#include <string>
#include <vector>

#include "segmentation/read_volume.hpp"

namespace angio::pipeline {

/// The volumes and surfaces, by their names, of a folder that holds no DICOM, in their order; of
/// anything else none. @throws InputError (65) if it is a case's folder
std::vector<std::string> files_instead_of_dicom(const std::string& input,
                                                const segmentation::ReadOptions& options);

/// INPUT, or the one volume or surface of a folder that holds no DICOM.
/// @throws InputError (65)  it holds several, or it is a case's folder
std::string file_or_dicom(const std::string& input, const segmentation::ReadOptions& options);

/// Refuses a folder of several volumes and surfaces. @throws InputError (65)
[[noreturn]] void refuse_several(const std::string& folder, const std::vector<std::string>& files);

}  // namespace angio::pipeline
