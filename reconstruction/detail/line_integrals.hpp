#pragma once

#include <cstddef>
#include <vector>

#include "reconstruction/reconstruction.hpp"

namespace angio::reconstruction::detail {

/// What a run's pixels have where nothing lies in the beam: the 99.95th percentile of some frames,
/// spread over the run. A run without air in it takes the least that is in its beam for air, which
/// an offset of all line integrals is, and the ramp filter hardly passes.
/// @throws InputError  all pixels are the same (an empty or saturated run), or noise alone
double unattenuated(const RotationalRun& run);

/// p = ln(I0 / I) (Beer, Lambert), in place.
///
/// @param pixels  of one frame
/// @param mask    of the same size: it takes the place of I0, pixel by pixel; or null
/// @param air     I0
void to_line_integrals(float* pixels, const float* mask, std::size_t count, PixelRelation relation,
                       double air);

/// What a shutter covers takes the nearest open pixel's value.
void cover_shutter(float* pixels, int columns, int rows, const OpenField& field);

/// Line integrals of frames [first, first + count), with what a shutter covers filled in.
/// @param air  unattenuated(); of no matter where the run has masks
/// @return shape [count, rows, columns]
std::vector<float> read_line_integrals(const RotationalRun& run, int first, int count, double air);

}  // namespace angio::reconstruction::detail
