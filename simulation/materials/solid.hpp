#pragma once

#include "core/host_device.hpp"
#include "core/vec3.hpp"
#include "simulation/materials/membrane.hpp"
#include "simulation/materials/solid_law.hpp"
#include "simulation/materials/symmetric3.hpp"

/// Six-node wedges of the wall's solid: corners 0 1 2 on the lumen's side, 3 4 5 above them.
///
///     N_a = L_a (1 - z)/2,  N_a+3 = L_a (1 + z)/2,   L the triangle's barycentric coordinates
///     E   = sum_wedges sum_q w_q Psi(F_q) + sum_patches V U(v / V)
///
/// Two points q at the triangle's centre, z = +- 1/sqrt(3). They integrate the volume v and the
/// gradients of N exactly for any positions of the corners (in the triangle v's integrand is
/// linear, through the thickness quadratic), so that the patch test is passed; and they leave one
/// strainless mode besides the rigid ones, the twist of one triangle against the other, which
/// neighbours sharing vertices do not have in common.
///
/// The volumetric energy sees the mean dilatation v / V of a patch of wedges, as a rule two that
/// share a side. A surface has two triangles a vertex: one constraint a wedge would leave 1.5 free
/// coordinates a constraint and stiffens a narrowed tube with K/G = 50 by 6 % where two wedges
/// together, with 3 as in a mesh of bricks, do not lock (tests: SolidMesh.DoesNotLock...).
/// Source: Simo, Taylor, Pister, Comput. Methods Appl. Mech. Eng. 51 (1985) 177 (mean dilatation);
/// de Souza Neto, Andrade Pires, Owen, Int. J. Numer. Methods Eng. 62 (2005) 353 (over patches).
///
/// A pre-stress F0 (Gee, Foerster, Wall, Int. J. Numer. Methods Biomed. Eng. 26 (2010) 52) and a
/// plastic stretch Fp act at a point as F = dx/dX F0 Fp^-1; they are multiplied into the gradients
/// g_a = (F0 Fp^-1)^T dN_a/dX, so that F = sum_a x_a g_a^T costs the same with them.
namespace angio::simulation::detail {

inline constexpr int kWedgePoints = 2;
inline constexpr int kMostPatchWedges = 3;

/// What a quadrature point keeps.
template <class Real>
struct SolidPoint {
  Vec3T<Real> g[6];  ///< gradients of the shape functions [1/mm]
  Real weight{};     ///< unloaded volume of tissue that it stands for [mm^3]
};

/// One wedge; pointers into the arrays of a SolidView.
template <class Real>
struct SolidWedge {
  const SolidPoint<Real>* points = nullptr;  ///< shape [kWedgePoints]
  const Vec3T<Real>* fiber = nullptr;        ///< unit, shape [2]
  SolidLaw<Real> law;
};

/// The solid's arrays. Vertices are the solid's own numbers; x may point into a larger array.
template <class Real>
struct SolidView {
  const Vec3T<Real>* x = nullptr;            ///< [vertex]
  const int* corners = nullptr;              ///< [wedge][6]
  const SolidPoint<Real>* points = nullptr;  ///< [wedge][kWedgePoints]
  const Vec3T<Real>* fibers = nullptr;       ///< [wedge][2]
  const int* region = nullptr;               ///< [wedge]
  const SolidLaw<Real>* laws = nullptr;      ///< [region]
  const int* patch = nullptr;                ///< [wedge]
  const int* patch_begin = nullptr;          ///< [patch + 1]
  const int* patch_wedges = nullptr;         ///< of one region
  const Real* patch_volume = nullptr;        ///< V, unloaded [mm^3], [patch]
  const Real* patch_bulk = nullptr;          ///< K, times the tissue that V stands for [Pa]

  ANGIO_HOST_DEVICE SolidWedge<Real> wedge(int w) const {
    return {points + kWedgePoints * w, fibers + 2 * w, laws[region[w]]};
  }
  ANGIO_HOST_DEVICE void gather(int w, Vec3T<Real>* out) const {
    for (int a = 0; a < 6; ++a) out[a] = x[corners[6 * w + a]];
  }
};

namespace solid {

/// dN_a/d(r, s, z) at point q.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> parametric_gradient(int corner, int q) {
  constexpr Real kAbscissa = Real(0.57735026918962576);
  const bool top = corner >= 3;
  const int a = top ? corner - 3 : corner;
  const Real z = q == 0 ? -kAbscissa : kAbscissa;
  const Real share = Real(0.5) * (top ? Real(1) + z : Real(1) - z);
  const Real by_r = a == 0 ? Real(-1) : (a == 1 ? Real(1) : Real(0));
  const Real by_s = a == 0 ? Real(-1) : (a == 2 ? Real(1) : Real(0));
  return {by_r * share, by_s * share, (top ? Real(0.5) : Real(-0.5)) / Real(3)};
}

/// Of the parameter space that a point stands for.
template <class Real>
ANGIO_HOST_DEVICE constexpr Real parametric_weight() {
  return Real(0.5);
}

/// dx/d(r, s, z) at point q, columns by parameter. Of differences between corners: they keep the
/// digits far from the origin.
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> jacobian(const Vec3T<Real>* x, int q) {
  constexpr Real kAbscissa = Real(0.57735026918962576);
  const Real z = q == 0 ? -kAbscissa : kAbscissa;
  const Real low = Real(0.5) * (Real(1) - z), high = Real(0.5) * (Real(1) + z);
  const Vec3T<Real> by_r = low * (x[1] - x[0]) + high * (x[4] - x[3]);
  const Vec3T<Real> by_s = low * (x[2] - x[0]) + high * (x[5] - x[3]);
  const Vec3T<Real> by_z = (Real(0.5) / Real(3)) * ((x[3] - x[0]) + (x[4] - x[1]) + (x[5] - x[2]));
  Mat3T<Real> j;
  for (int i = 0; i < 3; ++i) {
    j(i, 0) = by_r[i];
    j(i, 1) = by_s[i];
    j(i, 2) = by_z[i];
  }
  return j;
}

/// The cofactor matrix, d det(A) / dA.
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> cofactor(const Mat3T<Real>& a) {
  Mat3T<Real> c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c(i, j) = a(i1, j1) * a(i2, j2) - a(i1, j2) * a(i2, j1);
    }
  return c;
}

/// F = sum_a x_a g_a^T
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> deformation(const SolidPoint<Real>& point,
                                                 const Vec3T<Real>* x) {
  Mat3T<Real> f;
  for (int a = 1; a < 6; ++a) f += outer(x[a] - x[0], point.g[a]);
  return f;
}

}  // namespace solid

/// The wedge's volume, exact for its curved sides [mm^3].
template <class Real>
ANGIO_HOST_DEVICE inline Real wedge_volume(const Vec3T<Real>* x) {
  Real v = 0;
  for (int q = 0; q < kWedgePoints; ++q)
    v += solid::parametric_weight<Real>() * determinant(solid::jacobian(x, q));
  return v;
}

/// dv/dx_a [mm^2]
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> wedge_volume_gradient(const Vec3T<Real>* x, int corner) {
  Vec3T<Real> by;
  for (int q = 0; q < kWedgePoints; ++q)
    by += solid::parametric_weight<Real>() *
          (solid::cofactor(solid::jacobian(x, q)) * solid::parametric_gradient<Real>(corner, q));
  return by;
}

/// The points of an unloaded wedge without pre-stress, in the shape X.
template <class Real>
ANGIO_HOST_DEVICE inline SolidPoint<Real> make_solid_point(const Vec3T<Real>* corners, int q) {
  const Mat3T<Real> j = solid::jacobian(corners, q);
  const Mat3T<Real> t = transpose(inverse(j));
  SolidPoint<Real> point;
  for (int a = 0; a < 6; ++a) point.g[a] = t * solid::parametric_gradient<Real>(a, q);
  point.weight = solid::parametric_weight<Real>() * determinant(j);
  return point;
}

/// The point with pre-stress and plastic stretch, S = F0 Fp^-1, multiplied in.
template <class Real>
ANGIO_HOST_DEVICE inline SolidPoint<Real> prestressed(const SolidPoint<Real>& point,
                                                      const Mat3T<Real>& s) {
  const Mat3T<Real> t = transpose(s);
  SolidPoint<Real> out;
  for (int a = 0; a < 6; ++a) out.g[a] = t * point.g[a];
  out.weight = point.weight / determinant(s);
  return out;
}

/// E of a wedge without the volumetric part [nJ]; infinite where it is inside out.
template <class Real>
ANGIO_HOST_DEVICE inline Real wedge_energy(const SolidWedge<Real>& wedge, const Vec3T<Real>* x) {
  Real energy = 0;
  SolidTangent<Real> tangent;
  for (int q = 0; q < kWedgePoints; ++q) {
    const SolidPoint<Real>& point = wedge.points[q];
    energy += point.weight *
              solid_stress(wedge.law, wedge.fiber, solid::deformation(point, x), tangent).value;
  }
  return energy;
}

/// dE/dx_a of a wedge under its patch's U', shape [6] [uN]; a point that is inside out adds
/// nothing.
template <class Real>
ANGIO_HOST_DEVICE inline void wedge_gradient(const SolidWedge<Real>& wedge, const Vec3T<Real>* x,
                                             Real pressure, Vec3T<Real>* gradient) {
  for (int a = 0; a < 6; ++a) gradient[a] = pressure * wedge_volume_gradient(x, a);
  SolidTangent<Real> tangent;
  for (int q = 0; q < kWedgePoints; ++q) {
    const SolidPoint<Real>& point = wedge.points[q];
    const SolidStress<Real> s =
        solid_stress(wedge.law, wedge.fiber, solid::deformation(point, x), tangent);
    for (int a = 0; a < 6; ++a) gradient[a] += point.weight * (s.p * point.g[a]);
  }
}

/// d2E/dx_a dx_b of a wedge under its patch's U', shape [6][6] [uN/mm], not clamped, without the
/// patch's U''.
///
///     sum_q w_q A_q : (g_a, g_b) + U' d2v/dx_a dx_b
///     (d2v/dx_a dx_b)_ik = sum_q w e_ikm (J (n_a x n_b))_m,  n the gradients by parameter
template <class Real>
ANGIO_HOST_DEVICE inline void wedge_hessian(const SolidWedge<Real>& wedge, const Vec3T<Real>* x,
                                            Real pressure, Mat3T<Real> (*hessian)[6]) {
  for (int a = 0; a < 6; ++a)
    for (int b = 0; b < 6; ++b) hessian[a][b] = {};
  for (int q = 0; q < kWedgePoints; ++q) {
    const SolidPoint<Real>& point = wedge.points[q];
    const Mat3T<Real> j = solid::jacobian(x, q);
    SolidTangent<Real> tangent;
    const bool valid =
        solid_stress(wedge.law, wedge.fiber, solid::deformation(point, x), tangent).valid;
    SeenGradient<Real> seen[6];
    for (int a = 0; a < 6 && valid; ++a) seen[a] = seen_gradient(tangent, point.g[a]);
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) {
        const Vec3T<Real> c = (pressure * solid::parametric_weight<Real>()) *
                              (j * cross(solid::parametric_gradient<Real>(a, q),
                                         solid::parametric_gradient<Real>(b, q)));
        Mat3T<Real>& h = hessian[a][b];
        if (valid) h += point.weight * solid_block(tangent, seen[a], seen[b]);
        h(0, 1) += c.z;
        h(1, 0) -= c.z;
        h(0, 2) -= c.y;
        h(2, 0) += c.y;
        h(1, 2) += c.x;
        h(2, 1) -= c.x;
      }
  }
}

/// U and its derivatives at a patch's mean dilatation [Pa], at the positions of the view.
template <class Real>
ANGIO_HOST_DEVICE inline VolumeEnergy<Real> patch_energy(const SolidView<Real>& view, int patch) {
  Real volume = 0;
  Vec3T<Real> x[6];
  for (int m = view.patch_begin[patch]; m < view.patch_begin[patch + 1]; ++m) {
    view.gather(view.patch_wedges[m], x);
    volume += wedge_volume(x);
  }
  return volume_energy(view.patch_bulk[patch], volume / view.patch_volume[patch]);
}

/// Gives the gradient of a patch and its wedges to a sink: add_gradient(vertex, slope).
template <class Real, class Sink>
inline void add_patch_gradient(const SolidView<Real>& view, int patch, Sink& sink) {
  const Real pressure = patch_energy(view, patch).d1;
  for (int m = view.patch_begin[patch]; m < view.patch_begin[patch + 1]; ++m) {
    const int w = view.patch_wedges[m];
    Vec3T<Real> x[6], gradient[6];
    view.gather(w, x);
    wedge_gradient(view.wedge(w), x, pressure, gradient);
    for (int a = 0; a < 6; ++a) sink.add_gradient(view.corners[6 * w + a], gradient[a]);
  }
}

/// Gives gradient and Hessian of a patch and its wedges to a sink: add_gradient(vertex, slope) and
/// add_block(i, j, block), the blocks once for each unordered pair, in an order that is always the
/// same.
///
/// @param clamp  changes a wedge's Hessian, shape [6][6], before it is given; what the patch adds,
///               U''/V dv dv^T, is never negative
template <class Real, class Sink, class Clamp>
inline void add_patch(const SolidView<Real>& view, int patch, Sink& sink, const Clamp& clamp) {
  const VolumeEnergy<Real> u = patch_energy(view, patch);
  int vertex[6 * kMostPatchWedges], count = 0;
  Vec3T<Real> by[6 * kMostPatchWedges];
  for (int m = view.patch_begin[patch]; m < view.patch_begin[patch + 1]; ++m) {
    const int w = view.patch_wedges[m];
    Vec3T<Real> x[6], gradient[6];
    Mat3T<Real> hessian[6][6];
    view.gather(w, x);
    wedge_gradient(view.wedge(w), x, u.d1, gradient);
    wedge_hessian(view.wedge(w), x, u.d1, hessian);
    clamp(hessian);
    for (int a = 0; a < 6; ++a) {
      const int v = view.corners[6 * w + a];
      sink.add_gradient(v, gradient[a]);
      for (int b = a; b < 6; ++b) sink.add_block(v, view.corners[6 * w + b], hessian[a][b]);
      int i = 0;
      while (i < count && vertex[i] != v) ++i;
      if (i == count) {
        vertex[count] = v;
        by[count++] = {};
      }
      by[i] += wedge_volume_gradient(x, a);
    }
  }
  const Real stiffness = u.d2 / view.patch_volume[patch];
  for (int i = 0; i < count; ++i)
    for (int j = i; j < count; ++j)
      sink.add_block(vertex[i], vertex[j], stiffness * outer(by[i], by[j]));
}

}  // namespace angio::simulation::detail
