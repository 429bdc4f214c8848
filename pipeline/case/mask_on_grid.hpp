#pragma once

#include <cstdint>

#include "core/volume.hpp"

namespace angio::pipeline {

/// The mask at the middles of another grid's voxels; 0 outside its own.
Volume<std::uint8_t> mask_on_grid(const Volume<float>& mask, const VolumeGeometry& grid);

}  // namespace angio::pipeline
