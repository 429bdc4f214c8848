#pragma once

#include <cstdint>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// How many tunnels run through the set voxels of a mask, at least: of a ring 1, of a tree 0, of a
/// sponge thousands. By Euler's number of the voxels as closed cubes, V - E + F - C = pieces -
/// tunnels + cavities, which single voxels tell (Kong, Rosenfeld, Computer Vision, Graphics, and
/// Image Processing 48:357, 1989); pieces and cavities are not counted, so that with p of the one
/// and c of the other p - 1 + c tunnels may be missed.
std::int64_t least_tunnels(const Volume<std::uint8_t>& mask);

}  // namespace angio::segmentation::detail
