#pragma once

#include <filesystem>

#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation::detail {

/// Checks that a MetaImage, NRRD or VTI file, with the files that it names, holds every byte that
/// its header promises: raw values are counted, compressed streams are followed to their end with
/// its checksum, written numbers are counted, an XML file must be closed. The libraries that read
/// them fill up what is missing, some without a word.
///
/// @param part  header: only what can be told from sizes, without reading the voxels
/// @throws InputError naming the file that is too short
void check_complete(const std::filesystem::path& path, VolumePart part);

}  // namespace angio::segmentation::detail
