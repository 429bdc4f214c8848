#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "core/select.hpp"
#include "core/vec3.hpp"

/// Symmetric 3 x 3 matrices by their eigenvalues.
namespace angio::simulation::detail {

/// A = Q diag(value) Q^T; the columns of Q are the eigenvectors, in no order.
template <class Real>
struct Eigen3 {
  Vec3T<Real> value;
  Mat3T<Real> vectors;
};

/// Cyclic Jacobi rotations (Golub, Van Loan, "Matrix Computations", section 8.5): exact for equal
/// eigenvalues too.
template <class Real>
ANGIO_HOST_DEVICE inline Eigen3<Real> eigen_decomposition(Mat3T<Real> a) {
  using std::abs;
  using std::sqrt;
  Eigen3<Real> out;
  out.vectors = Mat3T<Real>::identity();
  for (int sweep = 0; sweep < 12; ++sweep) {
    const Real off = abs(a(0, 1)) + abs(a(0, 2)) + abs(a(1, 2));
    const Real size = abs(a(0, 0)) + abs(a(1, 1)) + abs(a(2, 2));
    if (!(off > Real(1e-18) * size)) break;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (a(p, q) == Real(0)) continue;
        const Real theta = (a(q, q) - a(p, p)) / (Real(2) * a(p, q));
        const Real t =
            (theta < Real(0) ? Real(-1) : Real(1)) / (abs(theta) + sqrt(theta * theta + Real(1)));
        const Real c = Real(1) / sqrt(t * t + Real(1)), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const Real kp = a(k, p), kq = a(k, q);
          a(k, p) = c * kp - s * kq;
          a(k, q) = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const Real pk = a(p, k), qk = a(q, k);
          a(p, k) = c * pk - s * qk;
          a(q, k) = s * pk + c * qk;
          const Real kp = out.vectors(k, p), kq = out.vectors(k, q);
          out.vectors(k, p) = c * kp - s * kq;
          out.vectors(k, q) = s * kp + c * kq;
        }
        a(p, q) = a(q, p) = Real(0);
      }
  }
  out.value = {a(0, 0), a(1, 1), a(2, 2)};
  return out;
}

/// Q diag(value) Q^T
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> recomposed(const Eigen3<Real>& e) {
  Mat3T<Real> out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) out(i, j) += e.value[k] * e.vectors(i, k) * e.vectors(j, k);
  return out;
}

/// The inverse of a symmetric positive definite 3 x 3 block.
///
/// @param shift  added to the diagonal, as a share of the trace
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> inverse_block(
    Mat3T<Real> h, const Real& shift = Real(sizeof(Real) < 8 ? 1e-6 : 1e-9)) {
  const Real trace = h(0, 0) + h(1, 1) + h(2, 2);
  // No overflow in the determinant
  const Real scale = select(trace > Real(0), Real(1) / trace, Real(0));
  h = scale * h;
  for (int i = 0; i < 3; ++i) h(i, i) += shift;
  return scale * inverse(h);
}

}  // namespace angio::simulation::detail
