#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "core/select.hpp"

namespace angio {

/// Three numbers: a point, a direction or a force. The unit is the user's: [mm] unless a
/// docstring says otherwise.
template <class Real>
struct Vec3T {
  Real x{}, y{}, z{};

  ANGIO_HOST_DEVICE constexpr Real& operator[](int axis) {
    return axis == 0 ? x : (axis == 1 ? y : z);
  }
  ANGIO_HOST_DEVICE constexpr const Real& operator[](int axis) const {
    return axis == 0 ? x : (axis == 1 ? y : z);
  }
  ANGIO_HOST_DEVICE constexpr Vec3T& operator+=(const Vec3T& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
  ANGIO_HOST_DEVICE constexpr Vec3T& operator-=(const Vec3T& b) {
    x -= b.x;
    y -= b.y;
    z -= b.z;
    return *this;
  }
  ANGIO_HOST_DEVICE constexpr Vec3T& operator*=(Real s) {
    x *= s;
    y *= s;
    z *= s;
    return *this;
  }
  friend constexpr bool operator==(const Vec3T&, const Vec3T&) = default;
};

using Vec3 = Vec3T<double>;

template <class Real>
ANGIO_HOST_DEVICE constexpr Vec3T<Real> operator+(Vec3T<Real> a, const Vec3T<Real>& b) {
  return a += b;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Vec3T<Real> operator-(Vec3T<Real> a, const Vec3T<Real>& b) {
  return a -= b;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Vec3T<Real> operator-(const Vec3T<Real>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Vec3T<Real> operator*(Real s, Vec3T<Real> a) {
  return a *= s;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Vec3T<Real> operator*(Vec3T<Real> a, Real s) {
  return a *= s;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Vec3T<Real> operator/(Vec3T<Real> a, Real s) {
  return a *= Real(1) / s;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Real dot(const Vec3T<Real>& a, const Vec3T<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Vec3T<Real> cross(const Vec3T<Real>& a, const Vec3T<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Real norm_squared(const Vec3T<Real>& a) {
  return dot(a, a);
}
template <class Real>
ANGIO_HOST_DEVICE inline Real norm(const Vec3T<Real>& a) {
  using std::sqrt;
  return sqrt(dot(a, a));
}
template <class Real>
ANGIO_HOST_DEVICE inline Real distance(const Vec3T<Real>& a, const Vec3T<Real>& b) {
  return norm(a - b);
}
/// The unit vector along `a`; zero stays zero.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> normalized(const Vec3T<Real>& a) {
  const Real length = norm(a);
  return select(length > Real(0), Real(1) / length, Real(1)) * a;
}
/// A unit vector at right angles to the unit vector `a`; the same `a` gives the same answer.
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> any_perpendicular(const Vec3T<Real>& a) {
  const Real ax = a.x < 0 ? -a.x : a.x;
  const Real ay = a.y < 0 ? -a.y : a.y;
  const Real az = a.z < 0 ? -a.z : a.z;
  const Vec3T<Real> axis = (ax <= ay && ax <= az) ? Vec3T<Real>{1, 0, 0}
                           : (ay <= az)           ? Vec3T<Real>{0, 1, 0}
                                                  : Vec3T<Real>{0, 0, 1};
  return normalized(cross(a, axis));
}

/// A 3 x 3 matrix, rows first.
template <class Real>
struct Mat3T {
  Real m[3][3]{};

  ANGIO_HOST_DEVICE constexpr Real& operator()(int row, int column) { return m[row][column]; }
  ANGIO_HOST_DEVICE constexpr const Real& operator()(int row, int column) const {
    return m[row][column];
  }
  ANGIO_HOST_DEVICE static constexpr Mat3T identity() {
    Mat3T result;
    result.m[0][0] = result.m[1][1] = result.m[2][2] = Real(1);
    return result;
  }
  ANGIO_HOST_DEVICE constexpr Mat3T& operator+=(const Mat3T& b) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) m[i][j] += b.m[i][j];
    return *this;
  }
  friend constexpr bool operator==(const Mat3T&, const Mat3T&) = default;
};

using Mat3 = Mat3T<double>;

template <class Real>
ANGIO_HOST_DEVICE constexpr Mat3T<Real> operator+(Mat3T<Real> a, const Mat3T<Real>& b) {
  return a += b;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Mat3T<Real> operator*(Real s, Mat3T<Real> a) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a.m[i][j] *= s;
  return a;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Vec3T<Real> operator*(const Mat3T<Real>& a, const Vec3T<Real>& v) {
  return {a.m[0][0] * v.x + a.m[0][1] * v.y + a.m[0][2] * v.z,
          a.m[1][0] * v.x + a.m[1][1] * v.y + a.m[1][2] * v.z,
          a.m[2][0] * v.x + a.m[2][1] * v.y + a.m[2][2] * v.z};
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Mat3T<Real> operator*(const Mat3T<Real>& a, const Mat3T<Real>& b) {
  Mat3T<Real> c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) c.m[i][j] += a.m[i][k] * b.m[k][j];
  return c;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Mat3T<Real> transpose(const Mat3T<Real>& a) {
  Mat3T<Real> t;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) t.m[i][j] = a.m[j][i];
  return t;
}
/// a b^T
template <class Real>
ANGIO_HOST_DEVICE constexpr Mat3T<Real> outer(const Vec3T<Real>& a, const Vec3T<Real>& b) {
  Mat3T<Real> c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c.m[i][j] = a[i] * b[j];
  return c;
}
template <class Real>
ANGIO_HOST_DEVICE constexpr Real determinant(const Mat3T<Real>& a) {
  return a.m[0][0] * (a.m[1][1] * a.m[2][2] - a.m[1][2] * a.m[2][1]) -
         a.m[0][1] * (a.m[1][0] * a.m[2][2] - a.m[1][2] * a.m[2][0]) +
         a.m[0][2] * (a.m[1][0] * a.m[2][1] - a.m[1][1] * a.m[2][0]);
}
/// The inverse by cofactors; the caller sees to it that the determinant is not zero.
template <class Real>
ANGIO_HOST_DEVICE constexpr Mat3T<Real> inverse(const Mat3T<Real>& a) {
  const Real s = Real(1) / determinant(a);
  Mat3T<Real> b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int r0 = (j + 1) % 3, r1 = (j + 2) % 3, c0 = (i + 1) % 3, c1 = (i + 2) % 3;
      b.m[i][j] = s * (a.m[r0][c0] * a.m[r1][c1] - a.m[r0][c1] * a.m[r1][c0]);
    }
  return b;
}

}  // namespace angio
