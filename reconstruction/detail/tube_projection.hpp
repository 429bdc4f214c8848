#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "angiogram/cone_beam.hpp"
#include "reconstruction/detail/tree_curves.hpp"

/// How a frame sees the tubes around a tree's curves: the way of each pixel's ray through them.
namespace angio::reconstruction::detail {

/// A tree's curves at their samples.
struct SampledCurves {
  const TreeCurves* curves = nullptr;
  std::vector<std::vector<CurvePoint>> points;  ///< shape [curves][samples]
};
SampledCurves sample_curves(const TreeCurves& curves);

/// Where a ray passes a tube: at the foot of its distance from the curve, between two samples.
///
///     e(s) = P (S - c(s)),  P = I - d d^T;   e(s) . c'(s) = 0 with a fall of sign at the foot
struct TubeHit {
  int pixel = 0;
  int curve = 0, sample = 0;
  double part = 0.0;      ///< from that sample to the next, [0, 1)
  double distance = 0.0;  ///< of the ray from the curve [mm]
  double side = 0.0;      ///< the same, with the sign of the side that it passes on
  double radius = 0.0;    ///< of the tube [mm]
  double way = 0.0;       ///< through the tube [mm]
  double middle = 0.0;    ///< of that way, from the source [mm]
};

/// How far to both sides of its curve a tube is looked for.
enum class Reach {
  tube,          ///< where its way is not zero
  surroundings,  ///< a radius or three pixels more
};

/// A picture's rays and pixels.
struct FrameRays {
  explicit FrameRays(const angiogram::ConeBeamFrame& taken)
      : frame(taken),
        view(taken),
        pixel_mm(0.5 * (norm(taken.column_step) + norm(taken.row_step))) {}
  [[nodiscard]] Vec3 direction(int pixel) const {
    return normalized(frame.place(pixel % frame.columns, pixel / frame.columns) - frame.source);
  }
  angiogram::ConeBeamFrame frame;
  angiogram::ConeBeamView view;
  double pixel_mm;  ///< on the detector
};

/// All places where rays pass tubes, ordered by pixel, then by curve and sample.
/// @param width_pixels  of the box that blurs (blurred_chord())
/// @param wanted        one a pixel: whether it is; empty: all
std::vector<TubeHit> find_hits(const FrameRays& rays, const SampledCurves& curves,
                               double width_pixels, Reach reach, const std::vector<char>& wanted);

/// Pixels whose rays pass an open end of a curve, or one of its blanks, within the reach: no tube
/// tells what they see.
std::vector<int> find_end_pixels(const FrameRays& rays, const SampledCurves& curves,
                                 double width_pixels);

/// What changes the way of a ray: a parameter of the curves, and by how much.
struct WayGradient {
  std::vector<std::pair<int, double>> by_parameter;  ///< in no order; a parameter may come twice
  std::array<double, 6> by_motion{};                 ///< turn and shift of the frame (Motion)
  double by_width = 0.0;                             ///< of the box, by its logarithm
};

/// The way of one ray through the union of its tubes: those that overlap along it, as two branches
/// do where they meet, count once.
///
/// @param hits      of one pixel, [first, last)
/// @param gradient  filled where not null
double way_of_ray(const FrameRays& rays, const SampledCurves& curves, double width_pixels,
                  const TubeHit* first, const TubeHit* last, WayGradient* gradient);

}  // namespace angio::reconstruction::detail
