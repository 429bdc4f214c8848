#include "segmentation/detail/fields.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel.hpp"

namespace angio::segmentation::detail {
namespace {

/// Weights at distances 0, 1, ..., n voxels; the whole kernel sums to 1.
std::vector<float> gaussian_kernel(double sigma_voxels) {
  const int reach = std::max(1, int(std::ceil(3.5 * sigma_voxels)));
  std::vector<double> weights;
  double sum = 0.0;
  for (int t = 0; t <= reach; ++t) {
    // The Gaussian's mean over a voxel: exact also for kernels narrower than a voxel.
    const double s = std::sqrt(2.0) * sigma_voxels;
    weights.push_back(0.5 * (std::erf((t + 0.5) / s) - std::erf((t - 0.5) / s)));
    sum += (t == 0 ? 1.0 : 2.0) * weights.back();
  }
  std::vector<float> kernel;
  for (double w : weights) kernel.push_back(float(w / sum));
  return kernel;
}

void convolve_i(Volume<float>& volume, const std::vector<float>& kernel) {
  const int ni = volume.geometry.size[0];
  const int nj = volume.geometry.size[1];
  const int nk = volume.geometry.size[2];
  const int reach = int(kernel.size()) - 1;
  parallel_for(nk, [&](std::ptrdiff_t k) {
    std::vector<float> padded(std::size_t(ni + 2 * reach));
    for (int j = 0; j < nj; ++j) {
      float* row = &volume.at(0, j, int(k));
      std::copy(row, row + ni, padded.begin() + reach);
      std::fill_n(padded.begin(), reach, row[0]);
      std::fill_n(padded.begin() + reach + ni, reach, row[ni - 1]);
      const float* in = padded.data() + reach;
      for (int i = 0; i < ni; ++i) row[i] = kernel[0] * in[i];
      for (int t = 1; t <= reach; ++t)
        for (int i = 0; i < ni; ++i) row[i] += kernel[std::size_t(t)] * (in[i - t] + in[i + t]);
    }
  });
}

/// Convolves along j or k: the lines are `count` rows that lie `stride` rows apart.
void convolve_rows(Volume<float>& volume, const std::vector<float>& kernel, int axis) {
  const int ni = volume.geometry.size[0];
  const int nj = volume.geometry.size[1];
  const int nk = volume.geometry.size[2];
  const int reach = int(kernel.size()) - 1;
  const int count = axis == 1 ? nj : nk;
  const int lines = axis == 1 ? nk : nj;
  const auto width = std::size_t(ni);
  parallel_for(lines, [&](std::ptrdiff_t line) {
    const auto row = [&](int t) {
      return axis == 1 ? &volume.at(0, t, int(line)) : &volume.at(0, int(line), t);
    };
    std::vector<float> plane(width * std::size_t(count));
    for (int t = 0; t < count; ++t)
      std::copy(row(t), row(t) + ni, plane.begin() + std::ptrdiff_t(width) * t);
    for (int t = 0; t < count; ++t) {
      float* out = row(t);
      const float* middle = &plane[width * std::size_t(t)];
      for (int i = 0; i < ni; ++i) out[i] = kernel[0] * middle[i];
      for (int s = 1; s <= reach; ++s) {
        const float* below = &plane[width * std::size_t(std::max(t - s, 0))];
        const float* above = &plane[width * std::size_t(std::min(t + s, count - 1))];
        const float weight = kernel[std::size_t(s)];
        for (int i = 0; i < ni; ++i) out[i] += weight * (below[i] + above[i]);
      }
    }
  });
}

}  // namespace

Volume<float> smooth(const Volume<float>& volume, const Vec3& sigma_mm) {
  Volume<float> result = volume;
  for (int axis = 0; axis < 3; ++axis) {
    const double sigma_voxels = sigma_mm[axis] / volume.geometry.spacing[axis];
    if (sigma_voxels < 0.2) continue;
    const auto kernel = gaussian_kernel(sigma_voxels);
    if (axis == 0)
      convolve_i(result, kernel);
    else
      convolve_rows(result, kernel, axis);
  }
  return result;
}

Volume<float> smooth(const Volume<float>& volume, double sigma_mm) {
  return smooth(volume, Vec3{sigma_mm, sigma_mm, sigma_mm});
}

double mean_spacing(const VolumeGeometry& geometry) {
  return std::cbrt(geometry.spacing.x * geometry.spacing.y * geometry.spacing.z);
}

double voxel_volume(const VolumeGeometry& geometry) {
  return geometry.spacing.x * geometry.spacing.y * geometry.spacing.z;
}

Vec3 place_of_voxel(const VolumeGeometry& geometry, std::size_t offset) {
  const auto ni = std::size_t(geometry.size[0]), nj = std::size_t(geometry.size[1]);
  const std::size_t slice = offset / ni / nj;
  return geometry.lps_from_index({double(offset % ni), double(offset / ni % nj), double(slice)});
}

std::array<int, 3> block_size(const VolumeGeometry& geometry, double spacing_mm) {
  std::array<int, 3> factor{};
  for (int axis = 0; axis < 3; ++axis)
    factor[std::size_t(axis)] =
        std::clamp(int(spacing_mm / geometry.spacing[axis]), 1, geometry.size[std::size_t(axis)]);
  return factor;
}

Volume<float> block_average(const Volume<float>& volume, const std::array<int, 3>& factor) {
  if (factor == std::array<int, 3>{1, 1, 1}) return volume;
  const auto& fine = volume.geometry;
  VolumeGeometry coarse = fine;
  Vec3 first_centre;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = std::size_t(axis);
    coarse.size[a] = (fine.size[a] + factor[a] - 1) / factor[a];
    coarse.spacing[axis] = fine.spacing[axis] * factor[a];
    first_centre[axis] = 0.5 * (factor[a] - 1);
  }
  coarse.origin = fine.lps_from_index(first_centre);
  Volume<float> result(coarse);
  parallel_for(coarse.size[2], [&](std::ptrdiff_t k) {
    const int k_end = std::min(fine.size[2], (int(k) + 1) * factor[2]);
    for (int j = 0; j < coarse.size[1]; ++j) {
      const int j_end = std::min(fine.size[1], (j + 1) * factor[1]);
      for (int i = 0; i < coarse.size[0]; ++i) {
        const int i_end = std::min(fine.size[0], (i + 1) * factor[0]);
        double sum = 0.0;
        int count = 0;
        for (int kk = int(k) * factor[2]; kk < k_end; ++kk)
          for (int jj = j * factor[1]; jj < j_end; ++jj)
            for (int ii = i * factor[0]; ii < i_end; ++ii, ++count)
              sum += double(volume.at(ii, jj, kk));
        result.at(i, j, int(k)) = float(sum / count);
      }
    }
  });
  return result;
}

VolumeGeometry cropped_geometry(const VolumeGeometry& geometry, const VoxelBox& box) {
  VolumeGeometry part = geometry;
  part.size = box.size;
  part.origin =
      geometry.lps_from_index({double(box.first[0]), double(box.first[1]), double(box.first[2])});
  return part;
}

CoarseField::CoarseField(Volume<float> coarse, const std::array<int, 3>& factor)
    : coarse_(std::move(coarse)), factor_(factor) {}

void CoarseField::row(int first, int j, int k, int count, float* out) const {
  const auto& size = coarse_.geometry.size;
  const auto place = [&](int index, std::size_t axis) {
    const float x = (float(index) + 0.5f) / float(factor_[axis]) - 0.5f;
    return std::clamp(x, 0.0f, float(size[axis] - 1));
  };
  const float y = place(j, 1);
  const float z = place(k, 2);
  const int j0 = int(y), k0 = int(z);
  const int j1 = std::min(j0 + 1, size[1] - 1), k1 = std::min(k0 + 1, size[2] - 1);
  const float fy = y - float(j0), fz = z - float(k0);
  const float* r00 = &coarse_.at(0, j0, k0);
  const float* r10 = &coarse_.at(0, j1, k0);
  const float* r01 = &coarse_.at(0, j0, k1);
  const float* r11 = &coarse_.at(0, j1, k1);
  const auto column = [&](int c) {
    return (1.0f - fz) * ((1.0f - fy) * r00[c] + fy * r10[c]) +
           fz * ((1.0f - fy) * r01[c] + fy * r11[c]);
  };
  int cell = -1;
  float here = 0.0f, next = 0.0f;  // the columns before and behind the voxel
  bool has_next = false;
  for (int i = 0; i < count; ++i) {
    const float x = place(first + i, 0);
    const int i0 = int(x);
    const float fx = x - float(i0);
    if (i0 != cell) {
      here = has_next && i0 == cell + 1 ? next : column(i0);
      has_next = false;
      cell = i0;
    }
    if (fx > 0.0f && !has_next) {
      next = column(std::min(i0 + 1, size[0] - 1));
      has_next = true;
    }
    out[i] = fx > 0.0f ? (1.0f - fx) * here + fx * next : here;
  }
}

}  // namespace angio::segmentation::detail
