#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// Eigenvalues along a row, ascending [intensity / mm^2].
struct RowEigenvalues {
  std::vector<float> low, middle, high;
  explicit RowEigenvalues(int count)
      : low(std::size_t(count)), middle(std::size_t(count)), high(std::size_t(count)) {}
};

/// Eigenvalues of a symmetric matrix, ascending, in closed form.
/// Source: Smith, "Eigenvalues of a symmetric 3 x 3 matrix", CACM 4(4), 1961.
Vec3T<float> symmetric_eigenvalues(float xx, float yy, float zz, float xy, float xz, float yz);

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

  /// Finds the eigenvalues of the Hessian.
  void find(RowEigenvalues& result) const;

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
