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

/// Whether contrast medium comes into the vessels, or leaves them, during a run with masks; empty:
/// it does not, or there are none. The sum of all line integrals of a frame is the same from all
/// sides (the zeroth moment: Helgason, Ludwig; Natterer, The mathematics of computerized
/// tomography, 2001, section II.4), but for the beam's cone and what leaves the picture: under
/// two thirds at either end tells.
std::string doubt_of_filling(const RotationalRun& run);

}  // namespace angio::reconstruction::detail
