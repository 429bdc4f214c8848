#pragma once

#include <filesystem>

#include "dicom/identity.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::segmentation {

/// Whose scan a case was made from, and of which objects: what its results refer to in an archive.
///
/// @param source   what was given to read_volume or read_run, DICOM; its headers are read again
/// @param options  as given there, so that the same series is taken
/// @throws InputError if the source is not DICOM, or its series is not there any more
dicom::SourceLink read_source_link(const std::filesystem::path& source, const ReadOptions& options);

}  // namespace angio::segmentation
