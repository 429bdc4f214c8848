#pragma once

#include "simulation/step/vertex_forces.hpp"

/// The planes that part near pairs: no vertex may pass them until the next search.
namespace angio::simulation::detail {

/// Weights of the closest points of a candidate or a pair.
template <class Pair, class Real>
ANGIO_HOST_DEVICE inline GapWeights<Real> closest_points(const Pair& pair,
                                                         const Vec3T<Real> (&p)[4]) {
  if (pair.edges) return segment_segment_gap(p[0], p[1], p[2], p[3]);
  return pair.vertex[2] == pair.vertex[3] ? point_segment_gap(p[0], p[1], p[2])
                                          : point_triangle_gap(p[0], p[1], p[2], p[3]);
}

/// A plane between the two sides of a pair: along its unit normal side a lies above `low_a`, side b
/// below `high_b`.
template <class Real>
struct PartingPlane {
  Vec3T<Real> normal;  ///< from side b to side a; 0 where the two meet
  Real height[4]{};    ///< of the corners along it, from the first [mm]
  Real low_a{}, high_b{};
  Real distance{};  ///< of the closest points that were found: never less than the true one
  Real gap{};       ///< low_a - high_b, less its rounding: never more than the true distance
};

/// A pair's plane by its normal: what it proves does not depend on how the normal was found.
template <class Real, class Pair>
ANGIO_HOST_DEVICE inline PartingPlane<Real> plane_across(const Pair& pair, const Vec3T<Real>& gap,
                                                         const Vec3T<Real> (&p)[4]) {
  PartingPlane<Real> plane;
  plane.distance = norm(gap);
  plane.normal = plane.distance > Real(0) ? gap / plane.distance : Vec3T<Real>{};
  const int side_a = pair.edges ? 2 : 1;
  Real far = 0;
  for (int i = 0; i < 4; ++i) {
    const Real h = plane.height[i] = dot(plane.normal, p[i]), size = norm(p[i]);
    far = size > far ? size : far;
    if (i < side_a)
      plane.low_a = i == 0 || h < plane.low_a ? h : plane.low_a;
    else
      plane.high_b = i == side_a || h > plane.high_b ? h : plane.high_b;
  }
  plane.gap = plane.low_a - plane.high_b - Real(4) * kEpsilon<Real> * far;
  return plane;
}

/// sum w_i p_i; the weights sum to 0.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> weighted_gap(const GapWeights<Real>& weights,
                                                  const Vec3T<Real> (&p)[4]) {
  Vec3T<Real> gap;
  for (int i = 1; i < 4; ++i) gap += weights.w[i] * (p[i] - p[0]);
  return gap;
}

template <class Real, class Pair>
ANGIO_HOST_DEVICE inline Vec3T<Real> gap_between(const Pair& pair, const Vec3T<Real> (&p)[4]) {
  return weighted_gap(closest_points(pair, p), p);
}

/// A plane that proves less than this share of the distance found is looked for again.
inline constexpr double kSureShare = 0.9;

/// The plane across a pair's gap; p from its first vertex. The closest points of long edges that
/// lie along each other a tiny gap apart, or of slivers, drown in single precision: there they are
/// found in double precision, from the same positions.
template <class Real, class Pair>
ANGIO_HOST_DEVICE inline PartingPlane<Real> parting_plane(const Pair& pair,
                                                          const Vec3T<Real> (&p)[4]) {
  const PartingPlane<Real> plane = plane_across(pair, gap_between(pair, p), p);
  if (plane.gap >= Real(kSureShare) * plane.distance || sizeof(Real) >= sizeof(double))
    return plane;
  Vec3T<double> exact[4];
  for (int i = 1; i < 4; ++i) exact[i] = in_double(p[i]);
  const Vec3T<double> gap = gap_between(pair, exact);
  const double d = norm(gap);
  const Vec3T<double> unit = d > 0.0 ? gap / d : gap;  // before it is rounded
  PartingPlane<Real> again =
      plane_across(pair, Vec3T<Real>{Real(unit.x), Real(unit.y), Real(unit.z)}, p);
  again.distance = Real(d);
  return again.gap > plane.gap ? again : plane;
}

}  // namespace angio::simulation::detail
