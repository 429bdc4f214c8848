#pragma once

#include <vector>

#include "centerline/detail/polyline.hpp"
#include "centerline/detail/tube_samples.hpp"
#include "centerline/detail/wall.hpp"
#include "centerline/detail/wall_points.hpp"

namespace angio::centerline {

/// What a fit resolves.
struct TubeScale {
  double window = 0.0;       ///< half length of the stretch that is used, in radii; 0: by the noise
  int order = 0;             ///< of the harmonics; 0: by the noise
  double least_noise = 0.0;  ///< sd of wall points that is known from the vessel around [mm]
};

/// What the wall round a point of a line says.
struct TubeSection {
  bool valid = false;             ///< false: too little wall is seen
  Vec3 center;                    ///< the section's middle [mm]
  double inscribed_radius = 0.0;  ///< of the largest sphere near the middle [mm]
  double extent = 0.0;            ///< half the section's width where it is widest [mm]
  double area = 0.0;              ///< of the plane section [mm^2]
  double noise = 0.0;             ///< sd of the wall points round the model [mm]
  TubeScale scale;                ///< that was used
};

/// How carefully to look.
enum class TubeEffort {
  center,   ///< a fixed window and low order: to move a line to the middle
  measure,  ///< window and order by the noise: for the numbers that are kept
  follow  ///< measure with a window and an order that are given, and gather no more than these need
};

/// How far beside a point the line's course counts when a section is fitted there, in direction
/// reaches: longer windows need more of it.
inline double course_reach(TubeEffort effort) { return effort == TubeEffort::center ? 1.2 : 1.8; }

/// Which points of a line choose what a fit resolves, for themselves and those around.
enum class ScaleChoice {
  everywhere,
  sparse  ///< points a radius apart, in a fraction of the time
};

/// Fits a smooth tube to the wall points round one place of a line and measures its section there.
///
///     r(theta, s) = sum_m sum_k (a_mk cos m theta + b_mk sin m theta) s^k,  m <= M, k <= 2
///
/// in the frame of the line (s: foot of the point on the line, theta and r: round it), by least
/// squares with weights 1 - (s / h)^2 along the line and Tukey's biweight against points of other
/// walls (Huber, Robust Statistics, 1981). Flat sections are stretched to round ones first.
///
/// The window h is the longest whose estimates agree with those of all shorter ones within their
/// errors (intersection of confidence intervals: Goldenshluger, Nemirovski, Math. Methods Stat. 6,
/// 1997; Katkovnik, IEEE TSP 47(9), 1999, doi:10.1109/78.782208), so an exact surface is measured
/// where it is and a noisy one is averaged as far as its shape allows. The order M is that of the
/// least score of Akaike; harmonics that noise explains are shrunk away (garrote).
///
/// @param radius  of the vessel so far [mm]
/// @param extent  half its width where it is widest, so far [mm]
/// @param wall    to leave out points behind another wall; may be null
TubeSection fit_tube(const WallPoints& points, const LocalCurve& curve, double radius,
                     double extent, const Wall* wall, TubeEffort effort, TubeScale scale = {});

/// Measures the sections at points [first, last) of a line; the others stay invalid.
///
/// Where every wall point errs by itself (a surface), each point of the line first chooses window
/// and order for itself and is then measured with the median of what its neighbours within two
/// radii chose: a choice by the noise scatters, and the least radius along a line would be that of
/// the worst one. On a level set, whose errors go together, neighbours choose alike; but the few
/// errors around a throat do not tell how large they are, and look like a flat lumen. So every
/// eighth point is measured to learn the vessel's noise, the median within ten of the line's radii,
/// and then all with it.
///
/// @param choice  which points of a surface choose
std::vector<TubeSection> measure_tube(const WallPoints& points, const Polyline& line,
                                      std::size_t first, std::size_t last, const Wall* wall,
                                      ScaleChoice choice = ScaleChoice::everywhere);

/// How far away the wall is round a place: the lower third of its sectors, within `widest` [mm]; 0
/// when no wall is seen.
double look_for_wall(const WallPoints& points, const LocalCurve& curve, double widest);

}  // namespace angio::centerline
