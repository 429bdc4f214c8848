#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/tube_axes.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// Bones and organs that are about as bright as the vessels are.
struct Bones {
  std::vector<TubeAxis> tubes;   ///< of the volume, but those that are bones
  bool are_there = false;        ///< false: what follows is empty
  Volume<std::uint8_t> mask;     ///< 1 in them and in their blurred shells
  Volume<float> image_without;   ///< the image with the local background in their place
  BloodLevel level;              ///< of blood and soft tissue
  std::vector<TubeAxis> trunks;  ///< wide, even tubes of blood's level
  std::string warning;
};

/// Whether what was taken for pools of blood is muscle, as MR shows it between air and blood: over
/// a quarter of the scan is brighter than half way to it, more than blood, bones and organs with
/// contrast are of a CT scan.
bool is_muscle(const BloodLevel& level, const Volume<float>& volume);

/// Tells bones from vessels by what is inside: blood with contrast is as even as the scanner's
/// noise lets it be (evenness.hpp), bone is cortex, struts and marrow.
///
/// L is the level of even blood, and T that of soft tissue (find_even_level). What is
/// above (L + T) / 2, with the marrow that a section of it goes around, is parted at its necks
/// (part_into_bodies). Of the voxels that are deep enough in a body to show nothing else,
///
///   less than half above T + 0.7 (L - T), and less than 0.85 even, in a body deeper than 5 mm:
///                                                                               an organ or bone;
///   a quarter even, three tenths of that above T + 0.7 (L - T):                 blood;
///   a quarter even, but darker, in a body deeper than 5 mm:                     an organ;
///   less than a tenth even, and a tenth of the body cortex:                     bone;
///   less than a tenth even, in a body of twice the depth that tells:            bone or an organ.
///
/// Cortex is above L + 0.35 (L - T) in a piece of 0.3 ml or more: calcified plaque is smaller.
/// Where something darker than the brightest tubes told the level, a body whose depth is cortex
/// above L + (L - T) / 2 for the most part is none of it either. The others, thin vessels, veins
/// less filled and thin bones, go with the body that they hang on by the deepest neck. A body with
/// a seed is blood.
///
/// Nothing is bone where no blood is even (find_even_level), there is too little of it (5 ml) or
/// too much (a third of the scan), or four fifths of the wide tubes of blood's level were in it: in
/// a MR angiography blood pulsates, and is not even.
///
/// A bone may be a tube itself, as those of legs are: wide, uneven inside, and brighter than the
/// other tubes by over half of their contrast, where 15 mm or more of these are there.
///
/// @param axes  of the volume (find_tube_axes)
Bones find_bones(const Volume<float>& volume, const std::vector<TubeAxis>& axes,
                 const SegmentationOptions& options);

}  // namespace angio::segmentation::detail
