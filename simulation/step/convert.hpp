#pragma once

#include <vector>

#include "simulation/bodies/scene.hpp"
#include "simulation/materials/membrane.hpp"
#include "simulation/materials/solid.hpp"

/// Between the scene, in double precision, and a step.
namespace angio::simulation::detail {

template <class Real>
CornerMetric<Real> converted(const CornerMetric<double>& k) {
  return {Real(k.k11),    Real(k.k12), Real(k.k22), Real(k.inverse_det),
          Real(k.volume), Real(k.f1),  Real(k.f2)};
}

template <class Real>
MooneyRivlin<Real> converted(const MooneyRivlin<double>& m) {
  return {Real(m.c1), Real(m.c2)};
}

template <class Real>
MembraneLaw<Real> converted(const MembraneLaw<double>& law) {
  MembraneLaw<Real> result;
  result.base = converted<Real>(law.base);
  result.relaxed = law.relaxed;
  result.fibre.count = law.fibre.count;
  for (int i = 0; i < law.fibre.count; ++i) {
    result.fibre.i4[i] = Real(law.fibre.i4[i]);
    result.fibre.value[i] = Real(law.fibre.value[i]);
    result.fibre.slope[i] = Real(law.fibre.slope[i]);
    result.fibre.curvature[i] = Real(law.fibre.curvature[i]);
  }
  return result;
}

template <class To, class From>
Vec3T<To> converted(const Vec3T<From>& v) {
  return {To(v.x), To(v.y), To(v.z)};
}

template <class To, class From>
Mat3T<To> converted(const Mat3T<From>& a) {
  Mat3T<To> b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) b(i, j) = To(a(i, j));
  return b;
}

template <class Real, class Value>
auto converted_all(const std::vector<Value>& values) {
  std::vector<decltype(converted<Real>(values[0]))> result;
  result.reserve(values.size());
  for (const Value& value : values) result.push_back(converted<Real>(value));
  return result;
}

template <class Real>
std::vector<Real> converted_all(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

template <class To, class From>
SolidPoint<To> converted(const SolidPoint<From>& point) {
  SolidPoint<To> result;
  for (int a = 0; a < 6; ++a) result.g[a] = converted<To>(point.g[a]);
  result.weight = To(point.weight);
  return result;
}

template <class Real>
SolidLaw<Real> converted(const SolidLaw<double>& law) {
  return {Real(law.shear), Real(law.bulk),  Real(law.k1),   Real(law.k2),
          Real(law.share), Real(law.yield), Real(law.creep)};
}

/// Positions relative to the scene's origin: single precision needs small numbers.
template <class Real>
std::vector<Vec3T<Real>> local(const Scene& scene, const std::vector<Vec3>& x) {
  std::vector<Vec3T<Real>> result;
  result.reserve(x.size());
  for (const Vec3& p : x) result.push_back(converted<Real>(p - scene.origin));
  return result;
}

/// Back to patient space: the start in double precision and how far a vertex has gone from it.
template <class Real>
std::vector<Vec3> global(const Scene& scene, const Vec3T<Real>* start, const Vec3T<Real>* x) {
  std::vector<Vec3> result(scene.start.size());
  for (std::size_t v = 0; v < result.size(); ++v)
    result[v] = scene.start[v] + (converted<double>(x[v]) - converted<double>(start[v]));
  return result;
}

}  // namespace angio::simulation::detail
