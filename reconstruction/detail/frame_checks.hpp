#pragma once

#include <string>

#include "reconstruction/reconstruction.hpp"

/// What a run's pixels tell about themselves.
namespace angio::reconstruction::detail {

/// Whether the pixels' noise contradicts what the run says of them; empty: it does not.
///
/// Photons are counted: the variance of a pixel that is proportional to the beam I is proportional
/// to I, that of ln I to 1 / I (Poisson). So noise rises with brightness in linear pixels, and
/// falls in logarithmic ones. Noise is told by second differences along rows, block by block.
std::string doubt_of_relation(const RotationalRun& run);

/// Whether logarithmic pixels are no line integrals, as where the file does not say by what they
/// were multiplied: e^-16 of the beam is under what 16 bits hold. Empty: they may be.
/// @param air  unattenuated()
std::string doubt_of_scale(const RotationalRun& run, double air);

/// Whether contrast medium comes into the vessels, or leaves them, during a run with masks; empty:
/// it does not, or there are none. The sum of all line integrals of a frame is the same from all
/// sides (the zeroth moment: Helgason, Ludwig; Natterer, The mathematics of computerized
/// tomography, 2001, section II.4), but for the beam's cone and what leaves the picture: under
/// two thirds at either end tells.
std::string doubt_of_filling(const RotationalRun& run);

/// The same of a run without masks, by its volume: the line integrals of each frame where it sees
/// the volume's brightest small structures, above their mean over 10 mm around, are the same from
/// all sides but for what vessels overlap and how they are turned. Structures of bone stay, so
/// where they are brighter than vessels nothing is told.
/// @param air     unattenuated()
/// @param frames  where they were found to be, shape [frames]
std::string doubt_of_filling(const RotationalRun& run, double air,
                             const std::vector<angiogram::ConeBeamFrame>& frames,
                             const Volume<float>& volume);

}  // namespace angio::reconstruction::detail
