#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/tube_axes.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// Bones that are as bright as the vessels are, or brighter.
struct Bones {
  bool are_there = false;        ///< false: the rest is empty
  Volume<std::uint8_t> mask;     ///< 1 in them and in their blurred shells
  Volume<float> image_without;   ///< the image with the local background in their place
  BloodLevel level;              ///< of blood and soft tissue
  std::vector<TubeAxis> trunks;  ///< wide, even tubes of blood's level
  std::string warning;
};

/// Tells bones from vessels by what is inside: blood with contrast is as even as the scanner's
/// noise lets it be (evenness.hpp), bone is cortex, struts and marrow.
///
/// L is the median over wide tubes that are even, and T the commonest soft tissue
/// (find_even_level). What is above (L + T) / 2 is parted at its necks (part_into_bodies). A body
/// that is deep enough to be judged is blood if a quarter of its deep voxels are even, and bone if
/// less than a tenth are and a tenth of all its voxels are above L + 0.35 (L - T). The others, thin
/// vessels and thin bones, go with the body that they hang on by the deepest neck. A body with a
/// seed is blood. Nothing is bone where no wide tube is even, or there is too little of it.
///
/// @param axes  of the volume (find_tube_axes)
Bones find_bones(const Volume<float>& volume, const std::vector<TubeAxis>& axes,
                 const SegmentationOptions& options);

}  // namespace angio::segmentation::detail
