#include "segmentation/detail/edge_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.hpp"
#include "segmentation/detail/patch.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr int kBrick = 24;             ///< voxels along each side that are worked on at once
constexpr double kMostShift = 0.5;     ///< voxels that a step may move the boundary by
constexpr double kBandVoxels = 2.0;    ///< beside the boundary that are moved with it
constexpr float kMostResidual = 0.5f;  ///< more is something that the model does not know
constexpr float kLeastEdge = 0.03f;    ///< of the information a flat boundary holds
constexpr double kMostBlurVoxels = 3.0;
constexpr double kUpsampledVoxels =
    3.5;  ///< beside the boundary; further out the nearest voxel does

/// Weights at 0, 1, ... voxels of a Gaussian sampled there, as narrow as gives the weights the
/// variance asked for: far below a voxel, samples of that variance itself would have next to none.
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

/// Convolves along one axis; values beyond the patch repeat its border.
void convolve(Patch& patch, const std::vector<float>& kernel, int axis,
              std::vector<float>& scratch) {
  const int ni = patch.size[0], nj = patch.size[1], nk = patch.size[2];
  const int reach = int(kernel.size()) - 1;
  scratch.resize(patch.values.size());
  std::copy(patch.values.begin(), patch.values.end(), scratch.begin());
  const auto source = [&](int j, int k) {
    return scratch.data() + (std::size_t(k) * std::size_t(nj) + std::size_t(j)) * std::size_t(ni);
  };
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j) {
      float* out = patch.row(j, k);
      const float* middle = source(j, k);
      for (int i = 0; i < ni; ++i) out[i] = kernel[0] * middle[i];
      for (int t = 1; t <= reach; ++t) {
        const float w = kernel[std::size_t(t)];
        if (axis == 0) {
          for (int i = t; i < ni - t; ++i) out[i] += w * (middle[i - t] + middle[i + t]);
          for (int i = 0; i < ni; ++i)
            if (i < t || i >= ni - t)
              out[i] += w * (middle[std::max(i - t, 0)] + middle[std::min(i + t, ni - 1)]);
          continue;
        }
        const float* a = axis == 1 ? source(std::max(j - t, 0), k) : source(j, std::max(k - t, 0));
        const float* b =
            axis == 1 ? source(std::min(j + t, nj - 1), k) : source(j, std::min(k + t, nk - 1));
        for (int i = 0; i < ni; ++i) out[i] += w * (a[i] + b[i]);
      }
    }
}

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

/// P: the part of each voxel inside, from the distances at the voxels' centres.
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

std::array<std::vector<float>, 3> blur_kernels(const Blur& blur) {
  std::array<std::vector<float>, 3> kernels;
  for (int axis = 0; axis < 3; ++axis)
    kernels[std::size_t(axis)] = sampled_gaussian(blur.sd_voxels[axis] * blur.sd_voxels[axis]);
  return kernels;
}

int longest_reach(const std::array<std::vector<float>, 3>& kernels) {
  std::size_t most = 0;
  for (const auto& kernel : kernels) most = std::max(most, kernel.size());
  return int(most) - 1;
}

/// Sums over voxels for the blur's next value.
struct BlurSums {
  Mat3 matrix = Mat3{};  ///< of q_a q_b
  Vec3 right;            ///< of e q_a
};

/// The work on one brick, and its memory.
class BrickFit {
 public:
  BrickFit(const Volume<float>& phi, const FineGrid& fine, const EdgeModel& model,
           const std::array<std::vector<float>, 3>& blur, const std::vector<float>& window)
      : phi_(phi), fine_(fine), model_(model), blur_(blur), window_(window) {}

  /// The shift [mm] at the voxels of a brick and one beyond along each axis, and the blur's sums.
  std::vector<float> run(const Brick& brick, BlurSums& sums) {
    const int border = longest_reach(blur_) + int(window_.size()) + 1;
    const Brick wider{brick.first, {brick.size[0] + 1, brick.size[1] + 1, brick.size[2] + 1}};
    gather(distance_, phi_, fine_.ratio, wider, border);
    part_inside(share_, distance_, model_.image.geometry.spacing);
    for (int axis = 0; axis < 3; ++axis) convolve(share_, blur_[std::size_t(axis)], axis, scratch_);
    explain(brick.size, border, sums);
    for (int axis = 0; axis < 3; ++axis) {
      convolve(pull_, window_, axis, scratch_);
      convolve(hold_, window_, axis, scratch_);
    }
    return shifts(brick.size, border);
  }

 private:
  void explain(const std::array<int, 3>& size, int border, BlurSums& sums);
  [[nodiscard]] std::vector<float> shifts(const std::array<int, 3>& size, int border) const;

  const Volume<float>& phi_;
  const FineGrid& fine_;
  const EdgeModel& model_;
  const std::array<std::vector<float>, 3>& blur_;
  const std::vector<float>& window_;
  Patch distance_, share_, pull_, hold_;
  std::vector<float> scratch_;
};

void BrickFit::explain(const std::array<int, 3>& size, int border, BlurSums& sums) {
  const int ni = share_.size[0], nj = share_.size[1], nk = share_.size[2];
  const auto& grid = model_.image.geometry;
  const Vec3T<float> h{float(grid.spacing.x), float(grid.spacing.y), float(grid.spacing.z)};
  pull_.resize(share_.first, share_.size);
  hold_.resize(share_.first, share_.size);
  const int left = std::max(share_.first[0], 0);
  const int width = std::min(share_.first[0] + ni, grid.size[0]) - left;
  std::vector<float> lumen(std::size_t(std::max(width, 0))), background(lumen.size());
  for (int k = 1; k + 1 < nk; ++k)
    for (int j = 1; j + 1 < nj; ++j) {
      const int vj = share_.first[1] + j, vk = share_.first[2] + k;
      if (vj < 0 || vk < 0 || vj >= grid.size[1] || vk >= grid.size[2]) continue;
      const float *m = share_.row(j, k), *y0 = share_.row(j - 1, k), *y1 = share_.row(j + 1, k),
                  *z0 = share_.row(j, k - 1), *z1 = share_.row(j, k + 1);
      bool has_levels = false;
      for (int i = 1; i + 1 < ni; ++i) {
        const int vi = share_.first[0] + i;
        if (vi < 0 || vi >= grid.size[0]) continue;
        const Vec3T<float> g{(m[i + 1] - m[i - 1]) / (2.0f * h.x), (y1[i] - y0[i]) / (2.0f * h.y),
                             (z1[i] - z0[i]) / (2.0f * h.z)};
        const float squared = norm_squared(g);
        if (squared * h.x * h.x < 1e-5f) continue;
        const std::size_t v = grid.offset(vi, vj, vk);
        if (model_.is_foreign.values[v]) continue;
        if (!has_levels) {
          model_.levels.lumen.row(left, vj, vk, width, lumen.data());
          model_.levels.background.row(left, vj, vk, width, background.data());
          has_levels = true;
        }
        const float b = background[std::size_t(vi - left)];
        const float contrast = std::max({lumen[std::size_t(vi - left)] - b, model_.least_contrast,
                                         2.0f * (model_.intensity_min - b)});
        const float e = std::clamp((model_.image.values[v] - b) / contrast - m[i], -kMostResidual,
                                   kMostResidual);
        pull_.row(j, k)[i] = std::sqrt(squared) * e;
        hold_.row(j, k)[i] = squared;
        if (i < border || i >= border + size[0] || j < border || j >= border + size[1] ||
            k < border || k >= border + size[2])
          continue;
        const double twice = 2.0 * double(m[i]);
        const Vec3 q{0.5 * (double(m[i - 1] + m[i + 1]) - twice),
                     0.5 * (double(y0[i] + y1[i]) - twice), 0.5 * (double(z0[i] + z1[i]) - twice)};
        for (int a = 0; a < 3; ++a) {
          sums.right[a] += double(e) * q[a];
          for (int c = 0; c < 3; ++c) sums.matrix(a, c) += q[a] * q[c];
        }
      }
    }
}

std::vector<float> BrickFit::shifts(const std::array<int, 3>& size, int border) const {
  const Vec3& h = model_.image.geometry.spacing;
  const double voxel = std::cbrt(h.x * h.y * h.z);
  // |grad S|^2 on a flat boundary, seen through the window.
  double spread = 1.0 / 12.0;
  for (int a = 0; a < 3; ++a) {
    double variance = 0.0;
    const auto& kernel = blur_[std::size_t(a)];
    for (std::size_t n = 1; n < kernel.size(); ++n)
      variance += 2.0 * double(n * n) * double(kernel[n]);
    spread += variance / 3.0;
  }
  const auto least = float(kLeastEdge / (2.0 * 3.1416 * spread * voxel * voxel));
  const auto most = float(kMostShift * voxel);
  std::vector<float> shift;
  shift.reserve(std::size_t((size[0] + 1) * (size[1] + 1) * (size[2] + 1)));
  for (int k = 0; k <= size[2]; ++k)
    for (int j = 0; j <= size[1]; ++j)
      for (int i = 0; i <= size[0]; ++i) {
        const float u = pull_.row(j + border, k + border)[i + border] /
                        (hold_.row(j + border, k + border)[i + border] + least);
        shift.push_back(std::clamp(u, -most, most));
      }
  return shift;
}

/// Bricks with voxels that lie within a band beside the boundary.
std::vector<Brick> bricks_at_boundary(const Volume<float>& phi, const FineGrid& fine,
                                      const VolumeGeometry& voxels, float band_voxels) {
  const Vec3& h = voxels.spacing;
  const float band = band_voxels * float(std::max({h.x, h.y, h.z}));
  return bricks_with(voxels, kBrick, [&](const Brick& brick) {
    for (int k = 0; k < brick.size[2]; ++k)
      for (int j = 0; j < brick.size[1]; ++j)
        for (int i = 0; i < brick.size[0]; ++i)
          if (std::abs(phi.at((brick.first[0] + i) * fine.ratio[0],
                              (brick.first[1] + j) * fine.ratio[1],
                              (brick.first[2] + k) * fine.ratio[2])) < band)
            return true;
    return false;
  });
}

/// Moves the boundary inside one brick by shifts given at its voxels.
void move(Volume<float>& phi, const FineGrid& fine, const Brick& brick,
          const std::vector<float>& shift, float band) {
  const int rx = fine.ratio[0], ry = fine.ratio[1], rz = fine.ratio[2];
  const auto& size = phi.geometry.size;
  const int wi = brick.size[0] + 1, wj = brick.size[1] + 1;
  const auto at = [&](int i, int j, int k) { return shift[std::size_t((k * wj + j) * wi + i)]; };
  for (int k = 0; k < brick.size[2] * rz; ++k)
    for (int j = 0; j < brick.size[1] * ry; ++j) {
      const int fj = brick.first[1] * ry + j, fk = brick.first[2] * rz + k;
      if (fj >= size[1] || fk >= size[2]) continue;
      const int vj = j / ry, vk = k / rz;
      const float tj = float(j % ry) / float(ry), tk = float(k % rz) / float(rz);
      float* row = &phi.at(0, fj, fk);
      for (int i = 0; i < brick.size[0] * rx; ++i) {
        const int fi = brick.first[0] * rx + i;
        if (fi >= size[0] || std::abs(row[fi]) > band) continue;
        const int vi = i / rx;
        const float ti = float(i % rx) / float(rx);
        const auto line = [&](int b, int c) {
          return (1.0f - ti) * at(vi, b, c) + ti * at(vi + 1, b, c);
        };
        row[fi] -= (1.0f - tk) * ((1.0f - tj) * line(vj, vk) + tj * line(vj + 1, vk)) +
                   tk * ((1.0f - tj) * line(vj, vk + 1) + tj * line(vj + 1, vk + 1));
      }
    }
}

/// Axes of like spacing share one blur.
void improve_blur(Blur& blur, const BlurSums& sums, const Vec3& spacing) {
  std::array<int, 3> group{0, 1, 2};
  for (int a = 1; a < 3; ++a)
    for (int b = 0; b < a; ++b)
      if (std::abs(spacing[a] - spacing[b]) < 0.02 * spacing[a])
        group[std::size_t(a)] = group[std::size_t(b)];
  for (int a = 0; a < 3; ++a) {
    double right = 0.0, left = 0.0;
    for (int b = 0; b < 3; ++b) {
      if (group[std::size_t(b)] != group[std::size_t(a)]) continue;
      right += sums.right[b];
      for (int c = 0; c < 3; ++c)
        if (group[std::size_t(c)] == group[std::size_t(a)]) left += sums.matrix(b, c);
    }
    if (!(left > 0.0)) continue;
    const double variance = blur.sd_voxels[a] * blur.sd_voxels[a];
    const double better =
        std::clamp(variance + right / left, 0.25 * variance + 1e-3, 4.0 * variance + 0.1);
    blur.sd_voxels[a] = std::sqrt(std::clamp(better, 0.01, kMostBlurVoxels * kMostBlurVoxels));
    blur.is_told = true;
  }
}

/// Where a step of the fine grid lies between voxels: four of them and Catmull-Rom's weights.
struct CubicPlace {
  int nearest;
  std::array<int, 4> index{};
  std::array<float, 4> weight{};
  CubicPlace(int step, int ratio, int count)
      : nearest(std::min((step + ratio / 2) / ratio, count - 1)) {
    const int cell = step / ratio;
    const float t = float(step % ratio) / float(ratio);
    for (std::size_t s = 0; s < 4; ++s) index[s] = std::clamp(cell - 1 + int(s), 0, count - 1);
    weight = {0.5f * t * (-1.0f + t * (2.0f - t)), 1.0f + 0.5f * t * t * (3.0f * t - 5.0f),
              0.5f * t * (1.0f + t * (4.0f - 3.0f * t)), 0.5f * t * t * (t - 1.0f)};
  }
};

}  // namespace

VolumeGeometry FineGrid::geometry(const VolumeGeometry& voxels) const {
  VolumeGeometry result = voxels;
  for (std::size_t a = 0; a < 3; ++a) {
    result.size[a] = (voxels.size[a] - 1) * ratio[a] + 1;
    result.spacing[int(a)] = voxels.spacing[int(a)] / ratio[a];
  }
  return result;
}

Volume<float> refine_distance(const Volume<float>& distance, const FineGrid& fine) {
  Volume<float> result(fine.geometry(distance.geometry));
  const Vec3& h = distance.geometry.spacing;
  const auto band = float(kUpsampledVoxels * std::max({h.x, h.y, h.z}));
  const auto& size = distance.geometry.size;
  parallel_for_uneven(result.geometry.size[2], [&](std::ptrdiff_t fk) {
    for (int fj = 0; fj < result.geometry.size[1]; ++fj) {
      const CubicPlace z(int(fk), fine.ratio[2], size[2]), y(fj, fine.ratio[1], size[1]);
      const float* nearest = &distance.at(0, y.nearest, z.nearest);
      float* out = &result.at(0, fj, int(fk));
      for (int fi = 0; fi < result.geometry.size[0]; ++fi) {
        const CubicPlace x(fi, fine.ratio[0], size[0]);
        out[fi] = nearest[x.nearest];
        if (std::abs(out[fi]) > band) continue;
        float sum = 0.0f;
        for (std::size_t c = 0; c < 4; ++c) {
          if (z.weight[c] == 0.0f) continue;
          for (std::size_t b = 0; b < 4; ++b) {
            if (y.weight[b] == 0.0f) continue;
            const float* row = &distance.at(0, y.index[b], z.index[c]);
            sum += z.weight[c] * y.weight[b] *
                   (x.weight[0] * row[x.index[0]] + x.weight[1] * row[x.index[1]] +
                    x.weight[2] * row[x.index[2]] + x.weight[3] * row[x.index[3]]);
          }
        }
        out[fi] = sum;
      }
    }
  });
  return result;
}

void fit_edges(Volume<float>& phi, const FineGrid& fine, const EdgeModel& model, Blur& blur,
               int steps) {
  const Vec3& h = model.image.geometry.spacing;
  const auto band = float(kBandVoxels * std::max({h.x, h.y, h.z}));
  const double window_sd = std::clamp(std::sqrt(model.noise_share / 0.04), 0.5, 2.0);
  const auto window = sampled_gaussian(window_sd * window_sd);
  for (int step = 0; step < steps; ++step) {
    const auto bricks = bricks_at_boundary(phi, fine, model.image.geometry, 1.0f);
    const auto kernels = blur_kernels(blur);
    std::vector<std::vector<float>> shift(bricks.size());
    std::vector<BlurSums> sums(bricks.size());
    parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
      const auto n = std::size_t(b);
      BrickFit fit(phi, fine, model, kernels, window);
      shift[n] = fit.run(bricks[n], sums[n]);
    });
    parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
      move(phi, fine, bricks[std::size_t(b)], shift[std::size_t(b)], band);
    });
    BlurSums total;
    for (const BlurSums& part : sums)
      for (int a = 0; a < 3; ++a) {
        total.right[a] += part.right[a];
        for (int c = 0; c < 3; ++c) total.matrix(a, c) += part.matrix(a, c);
      }
    improve_blur(blur, total, h);
  }
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
        std::copy_n(part.row(j + border, k + border) + border, brick.size[0],
                    &share.at(brick.first[0], brick.first[1] + j, brick.first[2] + k));
  });
  return share;
}

}  // namespace angio::segmentation::detail
