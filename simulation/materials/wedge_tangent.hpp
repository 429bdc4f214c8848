#pragma once

#include "simulation/materials/solid.hpp"

/// A wedge's forces as a line around the place where its law was evaluated last.
///
///     dE/dx_a (x) = f_a + sum_b H_ab (x_b - X_b) + (u(v) - u(V)) dv/dx_a
///
/// X the corners' places then, f_a and H_ab the gradient and the Hessian of the wedge's own energy
/// there, u = dU/dv the pressure of its patch, v its volume, which is a line, too. H_ab holds the
/// change of u dv/dx_a with the shape at the pressure of X. The law of a fibre-reinforced wedge is
/// dear; of its line a sweep needs products only. The error is of second order in the strain since
/// X, which `has_moved` bounds.
namespace angio::simulation::detail {

/// Blocks (a, b), a <= b, of a symmetric matrix of 6 x 6 blocks, row by row.
ANGIO_HOST_DEVICE constexpr int wedge_block(int a, int b) { return a * (11 - a) / 2 + b; }
inline constexpr int kWedgeBlocks = 21;

/// Where a wedge's tangent was taken, and its volume's line: what every sweep looks at.
template <class Real>
struct WedgePlace {
  Vec3T<Real> x[6];                 ///< X [mm]
  Vec3T<Real> by_volume[6];         ///< dv/dx_a [mm^2]
  Real volume{};                    ///< at X [mm^3]
  Real dilatation[kWedgePoints]{};  ///< det F at X
  /// Of a corner and the one above it: the largest |d ln det F / dx| of a point at X [1/mm]
  Real steepness[3]{};
  bool is_pressed = false;  ///< is a point near its barrier?
  bool is_taken = false;
};

/// A slope as it is kept: in single precision, a sixteen-millionth off, for a sweep's time is that
/// of reading slopes. The constants go with the slopes that are kept: at X a wedge's force is
/// exact. A column's sums of slopes are rounded again: they leave its force about 5e-8 of the
/// largest off.
using Slope = Mat3T<float>;

template <class To, class From>
ANGIO_HOST_DEVICE inline Mat3T<To> in_precision(const Mat3T<From>& a) {
  Mat3T<To> out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out(i, j) = To(a(i, j));
  return out;
}

/// The forces' lines.
template <class Real>
struct WedgeTangent {
  /// f_a - sum_b H_ab (X_b - X_a), without the volumetric part [uN]
  Vec3T<Real> constant[6];
  Slope block[kWedgeBlocks];  ///< H_ab [uN/mm]
  Vec3T<Real> turn[3];  ///< the volume's part of block (a, a + 3): the vector of its cross product
};

/// The matrix of u -> u x w.
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> cross_matrix(const Vec3T<Real>& w) {
  Mat3T<Real> m;
  m(0, 1) = w.z;
  m(1, 0) = -w.z;
  m(0, 2) = -w.y;
  m(2, 0) = w.y;
  m(1, 2) = w.x;
  m(2, 1) = -w.x;
  return m;
}

/// H_ab for any two corners.
template <class Real>
ANGIO_HOST_DEVICE inline Slope tangent_block(const WedgeTangent<Real>& t, int a, int b) {
  return a <= b ? t.block[wedge_block(a, b)] : transpose(t.block[wedge_block(b, a)]);
}

/// Adds the volume of the wedge, its gradient, and the pressure's part of the Hessian. v is linear
/// in each corner: d2v / dx_a dx_b u = u x w, w = sum_q w_q J_q (dN_a x dN_b).
///
/// @param block  H_ab, shape [kWedgeBlocks], added to
/// @param turn   of the blocks (a, a + 3), shape [3], added to
template <class Real>
ANGIO_HOST_DEVICE inline void add_volume_tangent(Real pressure, WedgePlace<Real>& place,
                                                 Mat3T<Real>* block, Vec3T<Real>* turn) {
  const Vec3T<Real>* x = place.x;
  const Real weight = solid::parametric_weight<Real>();
  for (int q = 0; q < kWedgePoints; ++q) {
    const Mat3T<Real> j = solid::jacobian(x, q);
    const Mat3T<Real> c = weight * solid::cofactor(j);
    Vec3T<Real> n[6];
    for (int a = 0; a < 6; ++a) {
      n[a] = solid::parametric_gradient<Real>(a, q);
      place.by_volume[a] += c * n[a];
    }
    place.volume += weight * determinant(j);
    for (int a = 0; a < 6; ++a)
      for (int b = a + 1; b < 6; ++b) {
        const Vec3T<Real> w = (weight * pressure) * (j * cross(n[a], n[b]));
        block[wedge_block(a, b)] += cross_matrix(w);
        if (b == a + 3) turn[a] += w;
      }
  }
}

/// det F below which a point is watched.
inline constexpr double kNearPressed = 0.8;

/// @param pressure  dU/dv of the wedge's patch [Pa]
template <class Real>
ANGIO_HOST_DEVICE inline void take_tangent(const SolidView<Real>& view, int w, Real pressure,
                                           WedgePlace<Real>& place, WedgeTangent<Real>& out) {
  const SolidWedge<Real> wedge = view.wedge(w);
  Mat3T<Real> block[kWedgeBlocks];
  place = {};
  out = {};
  view.gather(w, place.x);
  for (int q = 0; q < kWedgePoints; ++q) {
    const SolidPoint<Real>& point = wedge.points[q];
    SolidTangent<Real> tangent;
    const SolidStress<Real> s =
        solid_stress(wedge.law, wedge.fiber, solid::deformation(point, place.x), tangent);
    place.dilatation[q] = s.valid ? determinant(tangent.f) : Real(0);
    place.is_pressed = place.is_pressed || !s.valid || place.dilatation[q] < Real(kNearPressed);
    if (!s.valid) continue;
    SeenGradient<Real> seen[6];
    for (int a = 0; a < 6; ++a) {
      seen[a] = seen_gradient(tangent, point.g[a]);
      out.constant[a] += point.weight * (s.p * point.g[a]);
    }
    for (int a = 0; a < 3; ++a) {
      const Real steep = norm(seen[a].t) + norm(seen[a + 3].t);
      if (steep > place.steepness[a]) place.steepness[a] = steep;
    }
    for (int a = 0; a < 6; ++a)
      for (int b = a; b < 6; ++b)
        block[wedge_block(a, b)] += point.weight * solid_block(tangent, seen[a], seen[b]);
  }
  add_volume_tangent(pressure, place, block, out.turn);
  for (int k = 0; k < kWedgeBlocks; ++k) out.block[k] = in_precision<float>(block[k]);
  for (int a = 0; a < 6; ++a)
    for (int b = a + 1; b < 6; ++b) {
      const Vec3T<Real> apart = place.x[b] - place.x[a];
      const Mat3T<Real> kept = in_precision<Real>(out.block[wedge_block(a, b)]);
      out.constant[a] -= kept * apart;
      out.constant[b] += transpose(kept) * apart;
    }
  place.is_taken = true;
}

/// The volume by its line [mm^3].
template <class Real>
ANGIO_HOST_DEVICE inline Real tangent_volume(const WedgePlace<Real>& t, const Vec3T<Real>* x) {
  Real v = t.volume;
  for (int a = 0; a < 6; ++a) v += dot(t.by_volume[a], x[a] - t.x[a]);
  return v;
}

/// Has an edge of the inner triangle, or one through the thickness, changed by more than a share of
/// its length, in length or direction?
template <class Real>
ANGIO_HOST_DEVICE inline bool has_moved(const WedgePlace<Real>& t, const Vec3T<Real>* x,
                                        Real share) {
  const auto changed = [&](int a, int b) {
    const Vec3T<Real> before = t.x[b] - t.x[a];
    return norm_squared(x[b] - x[a] - before) > share * share * norm_squared(before);
  };
  return changed(0, 1) || changed(0, 2) || changed(0, 3) || changed(1, 4) || changed(2, 5);
}

/// det F at a wedge's points.
template <class Real>
ANGIO_HOST_DEVICE inline void point_dilatations(const SolidPoint<Real>* points,
                                                const Vec3T<Real>* x,
                                                Real (&dilatation)[kWedgePoints]) {
  for (int q = 0; q < kWedgePoints; ++q)
    dilatation[q] = determinant(solid::deformation(points[q], x));
}

/// Has a point's dilatation changed by more than a share of it? Beside its barrier it can, while no
/// edge does: where a wedge leans over.
template <class Real>
ANGIO_HOST_DEVICE inline bool is_pressed_on(const WedgePlace<Real>& t,
                                            const SolidPoint<Real>* points, const Vec3T<Real>* x,
                                            Real share) {
  Real now[kWedgePoints];
  point_dilatations(points, x, now);
  bool changed = false;
  for (int q = 0; q < kWedgePoints; ++q) {
    const Real change = now[q] - t.dilatation[q];
    changed = changed || !(change * change < share * share * t.dilatation[q] * t.dilatation[q]);
  }
  return changed;
}

}  // namespace angio::simulation::detail
