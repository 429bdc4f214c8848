#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/host_device.hpp"
#include "reconstruction/reconstruction.hpp"

namespace angio::reconstruction::detail {

/// What a run's pixels have where nothing lies in the beam: the 99.95th percentile of some frames,
/// spread over the run. A run without air in it takes the least that is in its beam for air, which
/// an offset of all line integrals is, and the ramp filter hardly passes.
/// @throws InputError  all pixels are the same (an empty or saturated run), or noise alone
double unattenuated(const RotationalRun& run);

/// How a pixel becomes a line integral.
struct BeamRule {
  bool is_logarithmic = false;
  float air = 1.0F;    ///< I0, where there is no mask
  float least = 0.0F;  ///< of the beam: what is darker is the detector's own noise
};
BeamRule beam_rule(PixelRelation relation, double air);

/// p = ln(I0 / I) (Beer, Lambert); of a logarithmic pixel the difference.
/// @param mask  takes the place of I0, or null
ANGIO_HOST_DEVICE inline float line_integral(float pixel, const float* mask, const BeamRule& rule) {
  if (rule.is_logarithmic) return (mask ? *mask : rule.air) - pixel;
  const float without = !mask ? rule.air : *mask > rule.least ? *mask : rule.least;
  return std::log(without / (pixel > rule.least ? pixel : rule.least));
}

/// The same of a frame's pixels, in place.
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
/// The same of frames that need not follow each other.
std::vector<float> read_line_integrals(const RotationalRun& run, const std::vector<int>& frames,
                                       double air);

}  // namespace angio::reconstruction::detail
