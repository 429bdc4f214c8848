#pragma once

#include <filesystem>
#include <optional>

#include "core/units.hpp"
#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation::detail {

/// What a volume file is measured in where nobody says so: mm, unless its voxels would then be
/// finer than any angiography's (0.08 mm; flat detectors have 0.1 mm) and all of it under 30 mm
/// long; then the first of cm and m in which it is 30 to 2000 mm long.
LengthUnit guess_unit(const VolumeGeometry& grid);

/// Brings a volume to mm.
/// @param unit  that it is measured in; unset: of NIfTI mm (which the file states), else as
/// guessed,
///              with a warning where that is not mm
void bring_to_mm(VolumeFile& file, const std::filesystem::path& path,
                 const std::optional<LengthUnit>& unit);

}  // namespace angio::segmentation::detail
