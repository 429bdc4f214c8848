#pragma once

#include "simulation/materials/solid.hpp"

/// The wall's solid by columns: the copies of one lumen vertex through the wall are moved together,
/// by one Newton step in their own block of 3 x 3 blocks. Vertex by vertex the thin, nearly
/// incompressible layers hand a load on one sweep at a time.
namespace angio::simulation::detail {

inline constexpr int kMostColumnLevels = 8;

/// The columns of a solid whose vertices are numbered level by level, the lumen's first: the vertex
/// of column i at a level is level * stride + i.
template <class Real>
struct SolidColumns {
  int levels = 0;  ///< vertices of a column; 0: there is no solid
  int stride = 0;
  const int* layer = nullptr;        ///< [wedge]
  const int* patch_begin = nullptr;  ///< [column + 1]
  const int* patches = nullptr;      ///< those with a wedge at the column
};

/// Gradient and the symmetric block tridiagonal Hessian of a column.
template <class Real>
struct ColumnTerm {
  Vec3T<Real> gradient[kMostColumnLevels];
  Mat3T<Real> diagonal[kMostColumnLevels];
  Mat3T<Real> upper[kMostColumnLevels];  ///< block (l, l + 1)
};

/// Adds a wedge's points to a column that has the corners a and a + 3.
template <class Real>
ANGIO_HOST_DEVICE inline void add_column_wedge(const SolidWedge<Real>& wedge, const Vec3T<Real>* x,
                                               int a, int l, ColumnTerm<Real>& term) {
  for (int q = 0; q < kWedgePoints; ++q) {
    const SolidPoint<Real>& point = wedge.points[q];
    SolidTangent<Real> tangent;
    const SolidStress<Real> s =
        solid_stress(wedge.law, wedge.fiber, solid::deformation(point, x), tangent);
    if (!s.valid) continue;
    const SeenGradient<Real> low = seen_gradient(tangent, point.g[a]);
    const SeenGradient<Real> high = seen_gradient(tangent, point.g[a + 3]);
    term.gradient[l] += point.weight * (s.p * low.g);
    term.gradient[l + 1] += point.weight * (s.p * high.g);
    term.diagonal[l] += point.weight * solid_block(tangent, low, low);
    term.diagonal[l + 1] += point.weight * solid_block(tangent, high, high);
    term.upper[l] += point.weight * solid_block(tangent, low, high);
  }
}

/// Adds the patches around a column, each by one of the lanes (team.hpp).
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void add_solid_column(const SolidView<Real>& view,
                                               const SolidColumns<Real>& columns, int column,
                                               const Lanes& lanes, ColumnTerm<Real>& term) {
  for (int e = columns.patch_begin[column] + lanes.rank(); e < columns.patch_begin[column + 1];
       e += lanes.size()) {
    const int patch = columns.patches[e], begin = view.patch_begin[patch];
    const int first = view.patch_wedges[begin], l = columns.layer[first];
    Vec3T<Real> low, high;  // dv/dx of the patch
    Real volume = 0;
    for (int m = begin; m < view.patch_begin[patch + 1]; ++m) {
      const int w = view.patch_wedges[m];
      Vec3T<Real> x[6];
      view.gather(w, x);
      int a = 0;
      while (a < 3 && view.corners[6 * w + a] != l * columns.stride + column) ++a;
      for (int q = 0; q < kWedgePoints; ++q) {
        const Mat3T<Real> j = solid::jacobian(x, q);
        volume += solid::parametric_weight<Real>() * determinant(j);
        if (a == 3) continue;
        const Mat3T<Real> c = solid::parametric_weight<Real>() * solid::cofactor(j);
        low += c * solid::parametric_gradient<Real>(a, q);
        high += c * solid::parametric_gradient<Real>(a + 3, q);
      }
      if (a < 3) add_column_wedge(view.wedge(w), x, a, l, term);
    }
    const Real unloaded = view.patch_volume[patch];
    const VolumeEnergy<Real> u =
        volume_energy(view.laws[view.region[first]].bulk, volume / unloaded);
    const Real k = u.d2 / unloaded;
    term.gradient[l] += u.d1 * low;
    term.gradient[l + 1] += u.d1 * high;
    term.diagonal[l] += k * outer(low, low);
    term.diagonal[l + 1] += k * outer(high, high);
    term.upper[l] += k * outer(low, high);
  }
}

/// The inverse of a symmetric matrix whose eigenvalues below `least` are raised to it. Those of the
/// wall are above, as a rule: then no eigenvalues are needed.
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> inverse_above(const Mat3T<Real>& a, Real least) {
  const Mat3T<Real> over = a + (-least) * Mat3T<Real>::identity();
  if (over(0, 0) > Real(0) && over(0, 0) * over(1, 1) > over(0, 1) * over(0, 1) &&
      determinant(over) > Real(0))
    return inverse(a);
  Eigen3<Real> e = eigen_decomposition(a);
  for (int k = 0; k < 3; ++k) e.value[k] = Real(1) / (e.value[k] > least ? e.value[k] : least);
  return recomposed(e);
}

/// The Newton step of a column, -H^-1 g, with H made positive definite on the way: the block
/// elimination's pivots keep their eigenvalues above a small share of their trace.
template <class Real>
ANGIO_HOST_DEVICE inline void solve_column(const ColumnTerm<Real>& term, int levels,
                                           Vec3T<Real>* move) {
  constexpr Real kLeast = Real(1e-4);
  Mat3T<Real> inverse_pivot[kMostColumnLevels];
  Vec3T<Real> right[kMostColumnLevels];
  for (int l = 0; l < levels; ++l) {
    Mat3T<Real> pivot = term.diagonal[l];
    right[l] = -term.gradient[l];
    if (l > 0) {
      const Mat3T<Real> across = transpose(term.upper[l - 1]) * inverse_pivot[l - 1];
      pivot += Real(-1) * (across * term.upper[l - 1]);
      right[l] -= across * right[l - 1];
    }
    const Real trace = term.diagonal[l](0, 0) + term.diagonal[l](1, 1) + term.diagonal[l](2, 2);
    inverse_pivot[l] = inverse_above(Real(0.5) * (pivot + transpose(pivot)), kLeast * trace);
  }
  for (int l = levels - 1; l >= 0; --l) {
    if (l + 1 < levels) right[l] -= term.upper[l] * move[l + 1];
    move[l] = inverse_pivot[l] * right[l];
  }
}

}  // namespace angio::simulation::detail
