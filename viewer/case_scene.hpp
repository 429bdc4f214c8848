#pragma once

#include <filesystem>

#include "core/progress.hpp"
#include "formats/gltf.hpp"

namespace angio::viewer {

/// A case's simulation as a scene: the lumen (still) around the wall, the wall, the balloon and the
/// guidewire, which move through at most 40 written frames, the peak among them.
///
/// @throws InputError (66) if the case has no simulation
formats::GltfScene read_case_scene(const std::filesystem::path& case_folder,
                                   const Progress& progress = {});

}  // namespace angio::viewer
