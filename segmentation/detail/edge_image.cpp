#include "segmentation/detail/edge_image.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr int kBrick = 24;  ///< voxels along each side that are worked on at once

/// The part of a box on the inner side of a plane at a signed distance from its centre.
///
///     V = (a^3 - sum_i (a - m_i)^3 + sum_ij (a - m_i - m_j)^3) / (6 m_0 m_1 m_2),
///     m_i = |n_i| h_i,    a = (m_0 + m_1 + m_2) / 2 - d,    negative brackets count as 0
///
/// Source: Scardovelli & Zaleski, J. Comput. Phys. 164, 2000, doi:10.1006/jcph.2000.6567.
float part_behind_plane(double distance, Vec3 m) {
  const double least = 0.02 * (m.x + m.y + m.z);  // keeps the quotient well-conditioned
  for (int a = 0; a < 3; ++a) m[a] = std::max(m[a], least);
  const double half = 0.5 * (m.x + m.y + m.z);
  const auto cube = [](double x) { return x > 0.0 ? x * x * x : 0.0; };
  const double a = half - std::abs(distance);
  if (a <= 0.0) return distance < 0.0 ? 1.0f : 0.0f;
  const double cut = (cube(a) - cube(a - m.x) - cube(a - m.y) - cube(a - m.z) +
                      cube(a - m.x - m.y) + cube(a - m.x - m.z) + cube(a - m.y - m.z)) /
                     (6.0 * m.x * m.y * m.z);
  return float(distance < 0.0 ? 1.0 - cut : cut);
}

/// Catmull-Rom's weights at the steps between two voxels.
std::vector<std::array<float, 4>> cubic_weights(int ratio) {
  std::vector<std::array<float, 4>> weights;
  for (int step = 0; step < ratio; ++step) {
    const auto t = float(double(step) / ratio);
    weights.push_back({0.5f * t * (-1.0f + t * (2.0f - t)), 1.0f + 0.5f * t * t * (3.0f * t - 5.0f),
                       0.5f * t * (1.0f + t * (4.0f - 3.0f * t)), 0.5f * t * t * (t - 1.0f)});
  }
  return weights;
}

/// Refines a patch along one axis; of the voxels one is left out at the front and two behind.
void refine_axis(Patch& patch, int ratio, std::size_t axis, Patch& scratch) {
  std::swap(patch, scratch);
  const auto weights = cubic_weights(ratio);
  std::array<int, 3> size = scratch.size;
  size[axis] = (size[axis] - 3) * ratio;
  patch.resize(scratch.first, size);
  const std::array<std::ptrdiff_t, 3> stride{1, scratch.size[0],
                                             std::ptrdiff_t(scratch.size[0]) * scratch.size[1]};
  const std::ptrdiff_t one = stride[axis];
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j) {
      float* out = patch.row(j, k);
      for (int i = 0; i < size[0]; ++i) {
        std::array<int, 3> at{i, j, k};
        const auto& w = weights[std::size_t(at[axis] % ratio)];
        at[axis] /= ratio;
        const float* from = scratch.row(at[1], at[2]) + at[0];
        out[i] = w[0] * from[0] + w[1] * from[one] + w[2] * from[2 * one] + w[3] * from[3 * one];
      }
    }
}

}  // namespace

Volume<float> refine_near_zero(const Volume<float>& distance, const FineGrid& fine, float far_mm) {
  Volume<float> result(fine.geometry(distance.geometry));
  const auto bricks = bricks_with(distance.geometry, kBrick, [](const Brick&) { return true; });
  parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
    const Brick& brick = bricks[std::size_t(b)];
    Patch patch, scratch;
    gather(patch, distance, {1, 1, 1},
           {brick.first, {brick.size[0] + 1, brick.size[1] + 1, brick.size[2] + 1}}, 1);
    const bool is_near = std::any_of(patch.values.begin(), patch.values.end(),
                                     [&](float d) { return std::abs(d) < far_mm; });
    std::array<int, 3> first{}, size{};
    for (std::size_t a = 0; a < 3; ++a) {
      first[a] = brick.first[a] * fine.ratio[a];
      size[a] = std::min(brick.size[a] * fine.ratio[a], result.geometry.size[a] - first[a]);
      if (is_near) refine_axis(patch, fine.ratio[a], a, scratch);
    }
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j) {
        float* out = &result.at(first[0], first[1] + j, first[2] + k);
        if (is_near) {
          std::copy_n(patch.row(j, k), size[0], out);
          continue;
        }
        const float* from = patch.row(1 + j / fine.ratio[1], 1 + k / fine.ratio[2]) + 1;
        for (int i = 0; i < size[0]; ++i)
          out[i] = from[i / fine.ratio[0]] < 0.0f ? -far_mm : far_mm;
      }
  });
  return result;
}

std::vector<float> sampled_gaussian(double variance) {
  const int reach = std::max(1, int(std::ceil(3.5 * std::sqrt(variance))));
  const auto weights_of = [&](double v) {
    std::vector<double> weights;
    double sum = 0.0;
    for (int n = 0; n <= reach; ++n) {
      weights.push_back(std::exp(-0.5 * n * n / v));
      sum += (n == 0 ? 1.0 : 2.0) * weights.back();
    }
    for (double& w : weights) w /= sum;
    return weights;
  };
  double low = 1e-3, high = variance + 1.0;
  for (int step = 0; step < 40; ++step) {
    const double middle = 0.5 * (low + high);
    const auto weights = weights_of(middle);
    double reached = 0.0;
    for (std::size_t n = 1; n < weights.size(); ++n) reached += 2.0 * double(n * n) * weights[n];
    (reached < variance ? low : high) = middle;
  }
  std::vector<float> kernel;
  for (double w : weights_of(0.5 * (low + high))) kernel.push_back(float(w));
  return kernel;
}

void convolve(Patch& patch, const std::vector<float>& kernel, int axis,
              std::vector<float>& scratch) {
  const int reach = int(kernel.size()) - 1;
  const auto a = std::size_t(axis);
  std::swap(scratch, patch.values);
  const auto from_size = patch.size;
  const auto source = [&](int j, int k) {
    return scratch.data() + (std::size_t(k) * std::size_t(from_size[1]) + std::size_t(j)) *
                                std::size_t(from_size[0]);
  };
  patch.first[a] += reach;
  patch.size[a] -= 2 * reach;
  const auto [ni, nj, nk] = patch.size;
  patch.values.resize(std::size_t(ni) * std::size_t(nj) * std::size_t(nk));
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j) {
      float* out = patch.row(j, k);
      // The values t steps beside those of the row.
      const auto beside = [&](int t) {
        if (axis == 0) return source(j, k) + reach + t;
        return axis == 1 ? source(j + reach + t, k) : source(j, k + reach + t);
      };
      const float* middle = beside(0);
      for (int i = 0; i < ni; ++i) out[i] = kernel[0] * middle[i];
      for (int t = 1; t <= reach; ++t) {
        const float w = kernel[std::size_t(t)];
        const float *before = beside(-t), *behind = beside(t);
        for (int i = 0; i < ni; ++i) out[i] += w * (before[i] + behind[i]);
      }
    }
}

void part_inside(Patch& part, const Patch& distance, const Vec3& spacing) {
  const auto [ni, nj, nk] = distance.size;
  const Vec3 h = spacing;
  const auto widest = float(std::max({h.x, h.y, h.z}));
  const auto farthest = float(0.55 * norm(h));
  part.resize(distance.first, distance.size);
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j) {
      float* out = part.row(j, k);
      const float* m = distance.row(j, k);
      const float* y0 = distance.row(std::max(j - 1, 0), k);
      const float* y1 = distance.row(std::min(j + 1, nj - 1), k);
      const float* z0 = distance.row(j, std::max(k - 1, 0));
      const float* z1 = distance.row(j, std::min(k + 1, nk - 1));
      for (int i = 0; i < ni; ++i) {
        const float d = m[i];
        if (std::abs(d) > farthest) {
          out[i] = d < 0.0f ? 1.0f : 0.0f;
          continue;
        }
        const float x0 = m[std::max(i - 1, 0)], x1 = m[std::min(i + 1, ni - 1)];
        const Vec3 g{double(x1 - x0) / h.x, double(y1[i] - y0[i]) / h.y,
                     double(z1[i] - z0[i]) / h.z};
        const double length = std::max(norm(g), 1e-6);
        // h_a^2 d_aa, summed: what the bend takes from the box beyond its tangent plane.
        const float bend = (x0 + x1 + y0[i] + y1[i] + z0[i] + z1[i] - 6.0f * d) / 24.0f;
        const double moved = double(d + std::clamp(bend, -0.1f * widest, 0.1f * widest));
        out[i] =
            part_behind_plane(moved, {std::abs(g.x) * h.x / length, std::abs(g.y) * h.y / length,
                                      std::abs(g.z) * h.z / length});
      }
    }
}

BlurKernels blur_kernels(const Blur& blur) {
  BlurKernels kernels;
  for (int axis = 0; axis < 3; ++axis)
    kernels[std::size_t(axis)] = sampled_gaussian(blur.sd_voxels[axis] * blur.sd_voxels[axis]);
  return kernels;
}

int longest_reach(const BlurKernels& kernels) {
  std::size_t most = 0;
  for (const auto& kernel : kernels) most = std::max(most, kernel.size());
  return int(most) - 1;
}

bool is_at_boundary(const Volume<float>& phi, const FineGrid& fine, const Brick& brick,
                    float band_mm) {
  for (int k = 0; k < brick.size[2]; ++k)
    for (int j = 0; j < brick.size[1]; ++j) {
      const float* row =
          &phi.at(brick.first[0] * fine.ratio[0], (brick.first[1] + j) * fine.ratio[1],
                  (brick.first[2] + k) * fine.ratio[2]);
      for (int i = 0; i < brick.size[0]; ++i)
        if (std::abs(row[i * fine.ratio[0]]) < band_mm) return true;
    }
  return false;
}

std::vector<Brick> bricks_at_boundary(const Volume<float>& phi, const FineGrid& fine,
                                      const VolumeGeometry& voxels, float band_voxels) {
  const float band = band_voxels * float(voxels.longest_spacing());
  return bricks_with(voxels, kBrick,
                     [&](const Brick& brick) { return is_at_boundary(phi, fine, brick, band); });
}

VolumeGeometry FineGrid::geometry(const VolumeGeometry& voxels) const {
  VolumeGeometry result = voxels;
  for (std::size_t a = 0; a < 3; ++a) {
    result.size[a] = (voxels.size[a] - 1) * ratio[a] + 1;
    result.spacing[int(a)] = voxels.spacing[int(a)] / ratio[a];
  }
  return result;
}

Volume<float> blurred_share(const Volume<float>& phi, const FineGrid& fine,
                            const VolumeGeometry& voxels, const Blur& blur) {
  Volume<float> share(voxels);
  parallel_for(voxels.size[2], [&](std::ptrdiff_t k) {
    for (int j = 0; j < voxels.size[1]; ++j) {
      const float* from = &phi.at(0, j * fine.ratio[1], int(k) * fine.ratio[2]);
      float* out = &share.at(0, j, int(k));
      for (int i = 0; i < voxels.size[0]; ++i)
        out[i] = from[i * fine.ratio[0]] < 0.0f ? 1.0f : 0.0f;
    }
  });
  const auto kernels = blur_kernels(blur);
  const int border = longest_reach(kernels) + 1;
  const auto bricks = bricks_at_boundary(phi, fine, voxels, float(border));
  parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
    const Brick& brick = bricks[std::size_t(b)];
    Patch distance, part;
    std::vector<float> scratch;
    gather(distance, phi, fine.ratio, brick, border);
    part_inside(part, distance, voxels.spacing);
    for (int axis = 0; axis < 3; ++axis) convolve(part, kernels[std::size_t(axis)], axis, scratch);
    for (int k = 0; k < brick.size[2]; ++k)
      for (int j = 0; j < brick.size[1]; ++j)
        std::copy_n(part.at(brick.first[0], brick.first[1] + j, brick.first[2] + k), brick.size[0],
                    &share.at(brick.first[0], brick.first[1] + j, brick.first[2] + k));
  });
  return share;
}

}  // namespace angio::segmentation::detail
