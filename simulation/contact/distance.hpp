#pragma once

#include "core/host_device.hpp"
#include "core/vec3.hpp"

/// Closest points between a point and a triangle, and between two segments.
namespace angio::simulation::detail {

/// The gap between two primitives as a weighted sum of their four vertices:
/// gap = sum_i weight_i x_i, from the closest point of side b to that of side a; the weights of
/// side a sum to 1, those of side b to -1, so that forces along the gap conserve momentum.
template <class Real>
struct GapWeights {
  Real w[4]{};
};

/// Closest point of the triangle (a, b, c) to p, as weights {1, -u, -v, -w}.
///
/// Source: Ericson, Real-Time Collision Detection (2005), section 5.1.5.
template <class Real>
ANGIO_HOST_DEVICE inline GapWeights<Real> point_triangle_gap(const Vec3T<Real>& p,
                                                             const Vec3T<Real>& a,
                                                             const Vec3T<Real>& b,
                                                             const Vec3T<Real>& c) {
  const Vec3T<Real> ab = b - a, ac = c - a, ap = p - a;
  const Real d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= Real(0) && d2 <= Real(0)) return {{1, -1, 0, 0}};
  const Vec3T<Real> bp = p - b;
  const Real d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= Real(0) && d4 <= d3) return {{1, 0, -1, 0}};
  const Real vc = d1 * d4 - d3 * d2;
  if (vc <= Real(0) && d1 >= Real(0) && d3 <= Real(0)) {
    const Real t = d1 / (d1 - d3);
    return {{1, t - 1, -t, 0}};
  }
  const Vec3T<Real> cp = p - c;
  const Real d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= Real(0) && d5 <= d6) return {{1, 0, 0, -1}};
  const Real vb = d5 * d2 - d1 * d6;
  if (vb <= Real(0) && d2 >= Real(0) && d6 <= Real(0)) {
    const Real t = d2 / (d2 - d6);
    return {{1, t - 1, 0, -t}};
  }
  const Real va = d3 * d6 - d5 * d4;
  if (va <= Real(0) && (d4 - d3) >= Real(0) && (d5 - d6) >= Real(0)) {
    const Real t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {{1, 0, t - 1, -t}};
  }
  const Real s = Real(1) / (va + vb + vc);
  const Real v = vb * s, w = vc * s;
  return {{1, v + w - 1, -v, -w}};
}

/// Closest point of the segment (a, b) to p, as weights {1, t - 1, -t, 0}; of no length: a.
template <class Real>
ANGIO_HOST_DEVICE inline GapWeights<Real> point_segment_gap(const Vec3T<Real>& p,
                                                            const Vec3T<Real>& a,
                                                            const Vec3T<Real>& b) {
  const Vec3T<Real> ab = b - a;
  const Real along = dot(ab, p - a), whole = dot(ab, ab);
  const Real t = !(along > Real(0)) ? Real(0) : along < whole ? along / whole : Real(1);
  return {{1, t - 1, -t, 0}};
}

/// Closest points of the segments (p0, p1) and (q0, q1), as weights {1-s, s, t-1, -t}.
///
/// Source: Ericson, Real-Time Collision Detection (2005), section 5.1.9. Parallel segments give one
/// of their closest pairs.
template <class Real>
ANGIO_HOST_DEVICE inline GapWeights<Real> segment_segment_gap(const Vec3T<Real>& p0,
                                                              const Vec3T<Real>& p1,
                                                              const Vec3T<Real>& q0,
                                                              const Vec3T<Real>& q1) {
  const auto clamp01 = [](Real x) { return x < Real(0) ? Real(0) : (x > Real(1) ? Real(1) : x); };
  const Vec3T<Real> d1 = p1 - p0, d2 = q1 - q0, r = p0 - q0;
  const Real a = dot(d1, d1), e = dot(d2, d2), f = dot(d2, r), c = dot(d1, r), b = dot(d1, d2);
  const Real denominator = a * e - b * b;
  Real s = denominator > Real(0) ? clamp01((b * f - c * e) / denominator) : Real(0);
  Real t = (b * s + f) / e;
  if (t < Real(0)) {
    t = Real(0);
    s = clamp01(-c / a);
  } else if (t > Real(1)) {
    t = Real(1);
    s = clamp01((b - c) / a);
  }
  return {{1 - s, s, t - 1, -t}};
}

/// How far from parallel two edges are, sin^2 of the angle between them, in [0, 1].
template <class Real>
ANGIO_HOST_DEVICE inline Real sine_squared(const Vec3T<Real>& d1, const Vec3T<Real>& d2) {
  const Real scale = dot(d1, d1) * dot(d2, d2);
  return scale > Real(0) ? norm_squared(cross(d1, d2)) / scale : Real(0);
}

}  // namespace angio::simulation::detail
