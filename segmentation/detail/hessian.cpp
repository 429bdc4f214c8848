#include "segmentation/detail/hessian.hpp"

#include <cmath>
#include <numbers>

namespace angio::segmentation::detail {
namespace {

struct CosineSine {
  float cosine, sine;
};

/// Cosine and sine of acos(r) / 3 for r in [0, 1], to 1e-7, without the library's calls.
///
/// acos r = sqrt(1 - r) times a polynomial: Abramowitz & Stegun, Handbook of Mathematical
/// Functions, 4.4.46; the angle is at most pi / 6, so short series do for the rest.
CosineSine third_of_arc_cosine(float r) {
  float polynomial = -0.0012624911f;
  for (const float c : {0.0066700901f, -0.0170881256f, 0.0308918810f, -0.0501743046f, 0.0889789874f,
                        -0.2145988016f, 1.5707963050f})
    polynomial = polynomial * r + c;
  const float angle = std::sqrt(1.0f - r) * polynomial / 3.0f;
  const float a = angle * angle;
  return {1.0f + a * (-0.5f + a * (1.0f / 24.0f + a * (-1.0f / 720.0f + a / 40320.0f))),
          angle * (1.0f + a * (-1.0f / 6.0f + a * (1.0f / 120.0f - a / 5040.0f)))};
}

/// Without branches, so that a compiler can work on several at once.
inline Vec3T<float> eigenvalues_of(float xx, float yy, float zz, float xy, float xz, float yz) {
  const float mean = (xx + yy + zz) / 3.0f;
  const float a = xx - mean, b = yy - mean, c = zz - mean;
  const float off = xy * xy + xz * xz + yz * yz;
  const float p = std::sqrt((a * a + b * b + c * c + 2.0f * off) / 6.0f);
  const float half_determinant =
      0.5f * (a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz));
  const float cube = p * p * p;
  const float quotient = half_determinant / (cube > 0.0f ? cube : 1.0f);
  const float r = quotient < -1.0f ? -1.0f : (quotient > 1.0f ? 1.0f : quotient);
  // With angle = acos|r| / 3 in [0, pi / 6] they lie at 2 p cos(angle + 2 n pi / 3), or mirrored.
  const auto [cosine, sine] = third_of_arc_cosine(std::abs(r));
  const float far = 2.0f * p * cosine;
  const float near = p * (cosine - std::numbers::sqrt3_v<float> * sine);
  const bool is_mirrored = r < 0.0f;
  return {is_mirrored ? mean - far : mean - far + near, is_mirrored ? mean + near : mean - near,
          is_mirrored ? mean + far - near : mean + far};
}

}  // namespace

Vec3T<float> symmetric_eigenvalues(float xx, float yy, float zz, float xy, float xz, float yz) {
  return eigenvalues_of(xx, yy, zz, xy, xz, yz);
}

void RowDifferences::find(RowEigenvalues& result) const {
  const float *m = rows_[1][1], *y0 = rows_[1][0], *y1 = rows_[1][2], *z0 = rows_[0][1],
              *z1 = rows_[2][1], *d00 = rows_[0][0], *d01 = rows_[0][2], *d10 = rows_[2][0],
              *d11 = rows_[2][2];
  float *low = result.low.data(), *middle = result.middle.data(), *high = result.high.data();
  const Vec3T<float> h = h_;
  const auto find_at = [=](int i, int i0, int i1) __attribute__((always_inline)) {
    const float xx = (m[i0] - 2.0f * m[i] + m[i1]) / (h.x * h.x);
    const float yy = (y0[i] - 2.0f * m[i] + y1[i]) / (h.y * h.y);
    const float zz = (z0[i] - 2.0f * m[i] + z1[i]) / (h.z * h.z);
    const float xy = (y1[i1] - y1[i0] - y0[i1] + y0[i0]) / (4.0f * h.x * h.y);
    const float xz = (z1[i1] - z1[i0] - z0[i1] + z0[i0]) / (4.0f * h.x * h.z);
    const float yz = (d11[i] - d10[i] - d01[i] + d00[i]) / (4.0f * h.y * h.z);
    const Vec3T<float> l = eigenvalues_of(xx, yy, zz, xy, xz, yz);
    low[i] = l.x;
    middle[i] = l.y;
    high[i] = l.z;
  };
  find_at(0, 0, std::min(1, last_));
#pragma omp simd
  for (int i = 1; i < last_; ++i) find_at(i, i - 1, i + 1);
  find_at(last_, std::max(last_ - 1, 0), last_);
}

}  // namespace angio::segmentation::detail
