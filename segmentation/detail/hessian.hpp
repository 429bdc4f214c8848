#pragma once

#include <algorithm>

#include "core/volume.hpp"
#include "segmentation/detail/vesselness.hpp"

namespace angio::segmentation::detail {

/// Central differences along one row of a volume; the border voxel is repeated beyond the border.
class RowDifferences {
 public:
  RowDifferences(const Volume<float>& volume, int j, int k)
      : last_(volume.geometry.size[0] - 1),
        h_{float(volume.geometry.spacing.x), float(volume.geometry.spacing.y),
           float(volume.geometry.spacing.z)} {
    for (int c = -1; c <= 1; ++c)
      for (int b = -1; b <= 1; ++b)
        rows_[c + 1][b + 1] = &volume.at(0, std::clamp(j + b, 0, volume.geometry.size[1] - 1),
                                         std::clamp(k + c, 0, volume.geometry.size[2] - 1));
  }

  /// Eigenvalues of the Hessian, ascending [intensity / mm^2].
  [[nodiscard]] Vec3T<float> eigenvalues(int i) const {
    const int i0 = std::max(i - 1, 0), i1 = std::min(i + 1, last_);
    const float *m = rows_[1][1], *y0 = rows_[1][0], *y1 = rows_[1][2], *z0 = rows_[0][1],
                *z1 = rows_[2][1];
    const float xx = (m[i0] - 2.0f * m[i] + m[i1]) / (h_.x * h_.x);
    const float yy = (y0[i] - 2.0f * m[i] + y1[i]) / (h_.y * h_.y);
    const float zz = (z0[i] - 2.0f * m[i] + z1[i]) / (h_.z * h_.z);
    const float xy = (y1[i1] - y1[i0] - y0[i1] + y0[i0]) / (4.0f * h_.x * h_.y);
    const float xz = (z1[i1] - z1[i0] - z0[i1] + z0[i0]) / (4.0f * h_.x * h_.z);
    const float yz =
        (rows_[2][2][i] - rows_[2][0][i] - rows_[0][2][i] + rows_[0][0][i]) / (4.0f * h_.y * h_.z);
    return symmetric_eigenvalues(xx, yy, zz, xy, xz, yz);
  }

  /// The gradient [intensity / mm].
  [[nodiscard]] Vec3T<float> gradient(int i) const {
    const int i0 = std::max(i - 1, 0), i1 = std::min(i + 1, last_);
    return {(rows_[1][1][i1] - rows_[1][1][i0]) / (2.0f * h_.x),
            (rows_[1][2][i] - rows_[1][0][i]) / (2.0f * h_.y),
            (rows_[2][1][i] - rows_[0][1][i]) / (2.0f * h_.z)};
  }

 private:
  int last_;
  Vec3T<float> h_;
  const float* rows_[3][3];
};

}  // namespace angio::segmentation::detail
