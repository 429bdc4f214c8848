#pragma once

#include "simulation/materials/solid.hpp"
#include "simulation/materials/solid_flow.hpp"

/// A wedge's forces as a line around the place where its law was evaluated last.
///
///     dE/dx_a (x) = f_a + sum_b H_ab (x_b - X_b) + (u(v) - u(V)) dv/dx_a
///
/// X the corners' places then, f_a the gradient of the wedge's own energy there, u = dU/dv the
/// pressure of its patch, v its volume, which is a line, too. The law of a fibre-reinforced wedge
/// is dear; of its line a sweep needs products only.
///
/// The slopes H_ab are dearer than the force, and are taken more rarely: H_ab is the Hessian at a
/// place Y, with the change of u dv/dx_a with the shape at the pressure of Y. The error of the
/// force is then |H(X) - H(Y)| |x - X|, of first order in the strain since X and of second order in
/// both: `has_moved` bounds the strains, `is_stiffer` the change of H.
namespace angio::simulation::detail {

/// Blocks (a, b), a <= b, of a symmetric matrix of 6 x 6 blocks, row by row.
ANGIO_HOST_DEVICE constexpr int wedge_block(int a, int b) { return a * (11 - a) / 2 + b; }
inline constexpr int kWedgeBlocks = 21;

/// Where a wedge's line was taken, and its volume's: what every sweep looks at.
template <class Real>
struct WedgePlace {
  Vec3T<Real> x[6];                 ///< X [mm]
  Vec3T<Real> x_slopes[6];          ///< Y [mm]
  Vec3T<Real> by_volume[6];         ///< dv/dx_a [mm^2]
  Real volume{};                    ///< at X [mm^3]
  Real dilatation[kWedgePoints]{};  ///< det F at X
  Real stiffness[kWedgePoints]{};   ///< solid_stiffness at Y [Pa]
  Real flowed{};                    ///< plastic strain since Y
  /// Of a corner and the one above it: the largest |d ln det F / dx| of a point at Y [1/mm]
  Real steepness[3]{};
  bool is_pressed = false;  ///< is a point near its barrier?
  bool may_flow = false;    ///< is a point near its yield stress?
  bool has_force = false;   ///< false: the law has changed since X
  bool has_slopes = false;
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

/// The force at X as the line has it: f_a - sum_b H_ab (X_b - X_a), without the volumetric part
/// [uN]
template <class Real>
struct WedgeForce {
  Vec3T<Real> constant[6];
};

/// The slopes at Y.
template <class Real>
struct WedgeTangent {
  Slope block[kWedgeBlocks];  ///< H_ab [uN/mm], without what the patch adds
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

/// The volume of the wedge and its gradient.
template <class Real>
ANGIO_HOST_DEVICE inline void take_volume(WedgePlace<Real>& place) {
  const Real weight = solid::parametric_weight<Real>();
  place.volume = Real(0);
  for (Vec3T<Real>& by : place.by_volume) by = {};
  for (int q = 0; q < kWedgePoints; ++q) {
    const Mat3T<Real> j = solid::jacobian(place.x, q);
    const Mat3T<Real> c = weight * solid::cofactor(j);
    for (int a = 0; a < 6; ++a) place.by_volume[a] += c * solid::parametric_gradient<Real>(a, q);
    place.volume += weight * determinant(j);
  }
}

/// Adds the pressure's part of the Hessian. v is linear in each corner:
/// d2v / dx_a dx_b u = u x w, w = sum_q w_q J_q (dN_a x dN_b).
///
/// @param block  H_ab, shape [kWedgeBlocks], added to
/// @param turn   of the blocks (a, a + 3), shape [3], added to
template <class Real>
ANGIO_HOST_DEVICE inline void add_pressure_slopes(Real pressure, const Vec3T<Real>* x,
                                                  Mat3T<Real>* block, Vec3T<Real>* turn) {
  const Real weight = solid::parametric_weight<Real>();
  for (int q = 0; q < kWedgePoints; ++q) {
    const Mat3T<Real> j = solid::jacobian(x, q);
    Vec3T<Real> n[6];
    for (int a = 0; a < 6; ++a) n[a] = solid::parametric_gradient<Real>(a, q);
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

/// The law at a wedge's points.
template <class Real>
struct WedgeLaw {
  SolidStress<Real> stress[kWedgePoints];
  SolidTangent<Real> tangent[kWedgePoints];
};

template <class Real>
ANGIO_HOST_DEVICE inline WedgeLaw<Real> evaluate_law(const SolidWedge<Real>& wedge,
                                                     const Vec3T<Real>* x) {
  WedgeLaw<Real> law;
  for (int q = 0; q < kWedgePoints; ++q)
    law.stress[q] = solid_stress(wedge.law, wedge.fiber, solid::deformation(wedge.points[q], x),
                                 law.tangent[q]);
  return law;
}

/// Has the law become stiffer or softer since the slopes were taken, at a point, by more than a
/// share of what it was?
template <class Real>
ANGIO_HOST_DEVICE inline bool is_stiffer(const WedgePlace<Real>& place, const WedgeLaw<Real>& law,
                                         Real share) {
  bool changed = false;
  for (int q = 0; q < kWedgePoints; ++q) {
    const Real now = law.stress[q].valid ? solid_stiffness(law.tangent[q]) : Real(0);
    const Real change = now - place.stiffness[q];
    changed =
        changed || !(change * change <= share * share * place.stiffness[q] * place.stiffness[q]);
  }
  return changed;
}

/// Takes the slopes at the places x.
/// @param pressure  dU/dv of the wedge's patch [Pa]
template <class Real>
ANGIO_HOST_DEVICE inline void take_slopes(const SolidWedge<Real>& wedge, const WedgeLaw<Real>& law,
                                          Real pressure, const Vec3T<Real>* x,
                                          WedgePlace<Real>& place, WedgeTangent<Real>& out) {
  Mat3T<Real> block[kWedgeBlocks];
  for (Real& steep : place.steepness) steep = Real(0);
  for (Vec3T<Real>& turn : out.turn) turn = {};
  for (int q = 0; q < kWedgePoints; ++q) {
    place.stiffness[q] = Real(0);
    if (!law.stress[q].valid) continue;
    const SolidTangent<Real>& tangent = law.tangent[q];
    const SolidPoint<Real>& point = wedge.points[q];
    place.stiffness[q] = solid_stiffness(tangent);
    SeenGradient<Real> seen[6];
    for (int a = 0; a < 6; ++a) seen[a] = seen_gradient(tangent, point.g[a]);
    for (int a = 0; a < 3; ++a) {
      const Real steep = norm(seen[a].t) + norm(seen[a + 3].t);
      if (steep > place.steepness[a]) place.steepness[a] = steep;
    }
    for (int a = 0; a < 6; ++a)
      for (int b = a; b < 6; ++b)
        block[wedge_block(a, b)] += point.weight * solid_block(tangent, seen[a], seen[b]);
  }
  add_pressure_slopes(pressure, x, block, out.turn);
  for (int k = 0; k < kWedgeBlocks; ++k) out.block[k] = in_precision<float>(block[k]);
  for (int a = 0; a < 6; ++a) place.x_slopes[a] = x[a];
  place.flowed = Real(0);
  place.has_slopes = true;
}

/// Share of the yield stress up to which a wedge's points are taken not to flow, as long as the
/// force at X is good enough: a strain of 0.004 adds a fifth of it only where the law is very
/// stiff.
inline constexpr double kFarFromYield = 0.8;

/// Is a point of the wedge near its yield stress, or beyond?
template <class Real>
ANGIO_HOST_DEVICE inline bool may_flow(const SolidWedge<Real>& wedge, const WedgeLaw<Real>& law) {
  if (!(wedge.law.yield > Real(0))) return false;
  bool near = false;
  for (int q = 0; q < kWedgePoints; ++q)
    near =
        near || !law.stress[q].valid ||
        von_mises_stress(law.stress[q].p, law.tangent[q].f) > Real(kFarFromYield) * wedge.law.yield;
  return near;
}

/// Takes the force at the places x, and the volume.
/// @param slopes  H_ab
template <class Real>
ANGIO_HOST_DEVICE inline void take_force(const SolidWedge<Real>& wedge, const WedgeLaw<Real>& law,
                                         const Vec3T<Real>* x, const WedgeTangent<Real>& slopes,
                                         WedgePlace<Real>& place, WedgeForce<Real>& out) {
  for (int a = 0; a < 6; ++a) place.x[a] = x[a];
  out = {};
  place.is_pressed = false;
  place.may_flow = may_flow(wedge, law);
  for (int q = 0; q < kWedgePoints; ++q) {
    const SolidPoint<Real>& point = wedge.points[q];
    const SolidStress<Real>& s = law.stress[q];
    place.dilatation[q] = s.valid ? determinant(law.tangent[q].f) : Real(0);
    place.is_pressed = place.is_pressed || !s.valid || place.dilatation[q] < Real(kNearPressed);
    if (!s.valid) continue;
    for (int a = 0; a < 6; ++a) out.constant[a] += point.weight * (s.p * point.g[a]);
  }
  take_volume(place);
  for (int a = 0; a < 6; ++a)
    for (int b = a + 1; b < 6; ++b) {
      const Vec3T<Real> apart = x[b] - x[a];
      const Mat3T<Real> kept = in_precision<Real>(slopes.block[wedge_block(a, b)]);
      out.constant[a] -= kept * apart;
      out.constant[b] += transpose(kept) * apart;
    }
  place.has_force = true;
}

/// Takes force and slopes at the positions of the view.
/// @param pressure  dU/dv of the wedge's patch [Pa]
template <class Real>
ANGIO_HOST_DEVICE inline void take_tangent(const SolidView<Real>& view, int w, Real pressure,
                                           WedgePlace<Real>& place, WedgeTangent<Real>& slopes,
                                           WedgeForce<Real>& force) {
  const SolidWedge<Real> wedge = view.wedge(w);
  Vec3T<Real> x[6];
  view.gather(w, x);
  const WedgeLaw<Real> law = evaluate_law(wedge, x);
  take_slopes(wedge, law, pressure, x, place, slopes);
  take_force(wedge, law, x, slopes, place, force);
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
/// @param then  the corners' places before
template <class Real>
ANGIO_HOST_DEVICE inline bool has_moved(const Vec3T<Real>* then, const Vec3T<Real>* x, Real share) {
  const auto changed = [&](int a, int b) {
    const Vec3T<Real> before = then[b] - then[a];
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
