#pragma once

#include <vector>

#include "reconstruction/detail/orbit.hpp"
#include "reconstruction/reconstruction.hpp"

/// What beats in a run, told by its frames.
namespace angio::reconstruction::detail {

/// How far each frame's vessels lie along the axis from where the first frame has them [mm at the
/// isocentre].
///
/// Of each frame: line integrals that stand out of their row and are narrower than 8 mm there,
/// summed along the row. What turns around the axis keeps this profile but for the beam's cone
/// (each ray's plane sees the same attenuation from all sides), what moves along the axis shifts
/// it. Frames are compared with those before them, by the normalised correlation of their profiles,
/// to a fraction of a pixel; shifts add up.
///
/// Motion across the axis alone, and vessels that run along it from edge to edge, leave no signal.
std::vector<double> axial_shifts(const RotationalRun& run, double air, const Orbit& orbit,
                                 double pixel_mm, const Progress& progress);

/// A motion that comes back with each beat.
struct Beat {
  double rate_per_s = 0.0;     ///< 0: none was looked for, or R waves told it
  double amplitude_mm = 0.0;   ///< root mean square
  double f_ratio = 0.0;        ///< of its variance to what is left, by their degrees of freedom
  double resting_phase = 0.0;  ///< the middle of the fifth of the beat in which it moves least
};

/// The part of a signal that comes back with a phase,
///
///     s(t) = sum_k<K c_k cos(pi k t / T) + sum_h=1..3 (a_h cos(2 pi h p) + b_h sin(2 pi h p)),
///
/// by least squares under errors of which each carries over a part of the one before; K: slow
/// changes, as of breath, up to 30 a minute.
/// @param phases  p, a frame; whole numbers are beats
Beat beat_of(const std::vector<double>& signal, const std::vector<double>& times_s,
             const std::vector<double>& phases);

/// The same of an even rate that is not known: of the rates of 45 to 180 a minute at which the F
/// ratio is at its local greatest, the one where it is greatest; rate_per_s and f_ratio are 0 where
/// there is none. Vessels and bones that cross each other while the C-arm turns come back more
/// slowly, and a beat of less than that is not told from them.
Beat find_beat(const std::vector<double>& signal, const std::vector<double>& times_s);

}  // namespace angio::reconstruction::detail
