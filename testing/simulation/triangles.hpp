#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>

#include "simulation/materials/membrane.hpp"

/// Single triangles of the membrane in any state, and central differences in long double as the
/// truth.
namespace angio::simulation::testing {

using namespace detail;

inline constexpr double kThickness = 0.02;

template <class Real>
MooneyRivlin<Real> polyurethane() {
  return {Real(1.031e6), Real(3.69e6)};
}

// Fibres that stiffen, with a continuous second derivative: g' of x^2 + 2 x^3 at x = I4 - 1.
template <class Real>
FibreLaw<Real> fibres() {
  FibreLaw<Real> law;
  Real value{};
  for (const double x : {0.0, 0.1, 0.25, 0.6, 1.5}) {
    const Real modulus = Real(4e6), u = Real(x);
    const int n = law.count++;
    law.i4[n] = Real(1) + u;
    law.slope[n] = modulus * (u * u + Real(2) * u * u * u);
    law.curvature[n] = modulus * (Real(2) * u + Real(6) * u * u);
    value = modulus * (u * u * u / Real(3) + u * u * u * u / Real(2));
    law.value[n] = value;
  }
  return law;
}

template <class Real>
MembraneLaw<Real> law_of(bool relaxed, bool with_fibres) {
  MembraneLaw<Real> law{polyurethane<Real>(), {}, relaxed};
  if (with_fibres) law.fibre = fibres<Real>();
  return law;
}

// A triangle's unloaded and deformed corners, and its fibres' direction when unloaded.
template <class Real>
struct Element {
  Vec3T<Real> rest[3], x[3], fibre;
};

template <class To, class From>
Vec3T<To> convert(const Vec3T<From>& a) {
  return {To(a.x), To(a.y), To(a.z)};
}

template <class To, class From>
Element<To> convert(const Element<From>& t) {
  Element<To> out;
  for (int v = 0; v < 3; ++v) {
    out.rest[v] = convert<To>(t.rest[v]);
    out.x[v] = convert<To>(t.x[v]);
  }
  out.fibre = convert<To>(t.fibre);
  return out;
}

template <class Real>
CornerMetric<Real> metric_of(const Element<Real>& t, int v) {
  return corner_metric(t.rest[v], t.rest[(v + 1) % 3], t.rest[(v + 2) % 3], Real(kThickness),
                       t.fibre);
}

template <class Real>
Real energy(const Element<Real>& t, const MembraneLaw<Real>& law, int v = 0) {
  const CornerMetric<Real> k = metric_of(t, v);
  return k.volume *
         membrane_energy(law, k, t.x[v] - t.x[(v + 1) % 3], t.x[(v + 2) % 3] - t.x[(v + 1) % 3])
             .value;
}

template <class Real>
VertexTerm<Real> term(const Element<Real>& t, int v, const MembraneLaw<Real>& law) {
  const CornerMetric<Real> k = metric_of(t, v);
  const Vec3T<Real> e1 = t.x[v] - t.x[(v + 1) % 3], e2 = t.x[(v + 2) % 3] - t.x[(v + 1) % 3];
  return membrane_term(k, membrane_energy(law, k, e1, e2), e1, e2);
}

// Gradient and Hessian over the corners v, n, m (9 unknowns) seen from corner v.
template <class Real>
struct Whole {
  Eigen::Matrix<Real, 9, 1> gradient;
  Eigen::Matrix<Real, 9, 9> hessian;
};

template <class Real>
Whole<Real> whole(const Element<Real>& t, int v, const MembraneLaw<Real>& law) {
  const int corner[3] = {v, (v + 1) % 3, (v + 2) % 3};
  const CornerMetric<Real> k = metric_of(t, v);
  const Vec3T<Real> e1 = t.x[corner[0]] - t.x[corner[1]], e2 = t.x[corner[2]] - t.x[corner[1]];
  const EdgeTerm<Real> edge = membrane_element(k, membrane_energy(law, k, e1, e2), e1, e2);
  const Real by[2][3] = {{1, -1, 0}, {0, -1, 1}};  // of e1 and e2 by the corners v, n, m
  Whole<Real> out;
  out.gradient.setZero();
  out.hessian.setZero();
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 3; ++i)
      for (int e = 0; e < 2; ++e) {
        out.gradient(3 * corner[a] + i) += by[e][a] * edge.gradient[e][i];
        for (int b = 0; b < 3; ++b)
          for (int j = 0; j < 3; ++j)
            for (int f = 0; f < 2; ++f)
              out.hessian(3 * corner[a] + i, 3 * corner[b] + j) +=
                  by[e][a] * by[f][b] * edge.hessian[e][f](i, j);
      }
  return out;
}

// Central differences in long double: their own error is far below 1e-6.
inline Whole<long double> differences(const Element<double>& t,
                                      const MembraneLaw<long double>& law) {
  const auto exact = convert<long double>(t);
  long double h = 1e-6L;  // of the least height
  for (int v = 0; v < 3; ++v) {
    const auto a = exact.x[(v + 1) % 3] - exact.x[v], b = exact.x[(v + 2) % 3] - exact.x[v];
    h = std::min(h, 1e-6L * norm(cross(a, b)) / std::max(norm(a), norm(b)));
  }
  Whole<long double> out;
  for (int v = 0; v < 3; ++v)
    for (int axis = 0; axis < 3; ++axis) {
      auto up = exact, down = exact;
      up.x[v][axis] += h;
      down.x[v][axis] -= h;
      out.gradient(3 * v + axis) = (energy(up, law) - energy(down, law)) / (2.0L * h);
      out.hessian.col(3 * v + axis) =
          (whole(up, 0, law).gradient - whole(down, 0, law).gradient) / (2.0L * h);
    }
  return out;
}

// A triangle stretched by l1 and l2 along turned axes in its plane, then turned in space.
inline Element<double> stretched(double l1, double l2, double aspect, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  const double angle = 3.0 * u(random), c = std::cos(angle), s = std::sin(angle);
  const Vec3 a = normalized(Vec3{u(random) - 0.5, u(random) - 0.5, u(random) + 0.1});
  const Vec3 b = any_perpendicular(a), n = cross(a, b);
  Element<double> t;
  t.rest[0] = {0, 0, 0};
  t.rest[1] = {0.4, 0.05 * aspect * u(random), 0};
  t.rest[2] = {0.2 * u(random), 0.4 * aspect, 0};
  t.fibre = {u(random) - 0.5, u(random) - 0.5, u(random)};  // its part in the plane counts
  for (int v = 0; v < 3; ++v) {
    const double p = l1 * (c * t.rest[v].x + s * t.rest[v].y);
    const double q = l2 * (-s * t.rest[v].x + c * t.rest[v].y);
    t.x[v] = p * b + q * n + Vec3{1.0, -2.0, 3.0};
  }
  return t;
}

// A force and a stiffness of the order that the triangle has.
inline double force_scale(double aspect) {
  return polyurethane<double>().c2 * kThickness * 0.4 / std::min(1.0, aspect);
}
inline double stiffness_scale(double aspect) {
  return force_scale(aspect) / (0.4 * std::min(1.0, aspect));
}

}  // namespace angio::simulation::testing
