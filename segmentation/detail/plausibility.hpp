#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// More than arteries, heart and lungs together hold: of 5 l of blood arteries have 13 %, the heart
/// 7 %, the vessels of the lungs 9 % (Guyton, Hall, Textbook of Medical Physiology, 11th ed. 2006,
/// ch. 14); a fifth more for large people [mm^3].
inline constexpr double kMostBlood = 1.75e6;

/// Refuses half of what was scanned, and more than 1.75 l, which arteries, heart and lungs together
/// do not hold.
///
/// @throws InputError if it is, with what helps
void refuse_flood(const Volume<std::uint8_t>& mask, const VolumeGeometry& scanned);

/// Tells whether a lumen can be one of vessels, whatever it was made from.
///
/// Over 30 % of what was scanned is told. So is a place farther
/// than 20 mm from any wall: but for aneurysms of the aorta, no artery has one, a heart's chamber
/// and tissue do. What is wider than 10 mm and reaches the border of the scan nowhere is told, too:
/// no vessel of that width begins and ends in a scan, but bowel with contrast medium does.
///
/// @param scanned  what vessels were looked for in
/// @return warnings, with what helps
/// @throws InputError if it cannot
std::vector<std::string> check_plausibility(const Volume<float>& level_set,
                                            const VolumeGeometry& scanned);

/// Refuses what is both a fifth of what was scanned and run through by over a thousand tunnels, or
/// by over three thousand: tissue among noise and bone are such sponges. Of the trees (VesselTree)
/// in 23 scans of vessels the most had 1,010 (an aorta with a stent); a plain head has 4,161, a jaw
/// 20,177. Where a person gave seeds, only the first holds.
///
/// @throws InputError if it is, with what helps
void refuse_sponge(const Volume<std::uint8_t>& mask, const VolumeGeometry& scanned, bool has_seeds);

/// Refuses what closes around 0.3 l or more, in sections along the grid's planes with a hole of
/// 40 cm^2 or more: a skull does, and the skin's fat; heart and great vessels close around less.
///
/// @throws InputError if it is, with what helps
void refuse_shell(const Volume<std::uint8_t>& mask);

/// Refuses less than 20 mm of vessel in a scan that is 150 mm or more across in two directions: a
/// body has longer ones, so that they did not stand out, and what did is calcium in a wall, a clip,
/// or noise.
///
/// @throws InputError if it is, with what helps
void refuse_crumb(const Volume<std::uint8_t>& mask, const VolumeGeometry& scanned);

/// Refuses what is not of one brightness, as blood is: inside of it, 0.7 voxels from the wall, the
/// 0.1 and the 0.9 quantile are 1.9 medians apart, as in bone, with cortex and marrow; in 23 scans
/// of vessels they were 0.2 to 1.05 medians apart, in one with the skull's base 1.8. Over 1.3 is
/// told. (An image whose air is not near
/// zero or below tells nothing.)
///
/// @param image  denoised
/// @return a warning, with what helps, or nothing
/// @throws InputError if it is
std::string check_evenness(const Volume<float>& level_set, const Volume<float>& image);

/// Tells of a lumen that is as bright as tissue: in a scan that holds air (below -500, as CT's
/// Hounsfield units have it), blood without contrast medium is at 30 to 60, and with it above 100.
///
/// @return a warning, with what helps, or nothing
std::string check_contrast(double lumen_intensity, const Volume<float>& scanned);

}  // namespace angio::segmentation::detail
