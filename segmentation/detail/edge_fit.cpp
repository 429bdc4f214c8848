#include "segmentation/detail/edge_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/parallel.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/patch.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kMostShift = 0.5;         ///< voxels that a step may move the boundary by
constexpr double kMovedVoxels = 2.0;       ///< beside the boundary that are moved with it
constexpr float kMostResidual = 0.5f;      ///< more is something that the model does not know
constexpr float kLifted = 0.1f;            ///< of the contrast: a background lifted by more
constexpr float kLeastEdge = 0.03f;        ///< of the information a flat boundary holds
constexpr int kBlockVoxels = 6;            ///< voxels along each side that share a misfit
constexpr double kNoiseOfOneVoxel = 0.04;  ///< of the contrast: asks for a window of one voxel
constexpr double kNarrowestWindow = 0.25;  ///< [voxels^2] variance
constexpr double kWidestWindow = 4.0;      ///< likewise

/// Sums over voxels for the blur's next value.
struct BlurSums {
  Mat3 matrix = Mat3{};  ///< of q_a q_b
  Vec3 right;            ///< of e q_a
};

/// What the image holds beside the model, in blocks of voxels: sums of |grad S|^2 e^2 and of
/// |grad S|^2.
struct Misfit {
  Volume<float> sum, weight;
  explicit Misfit(const VolumeGeometry& voxels) {
    VolumeGeometry blocks = voxels;
    for (std::size_t a = 0; a < 3; ++a) {
      blocks.size[a] = (voxels.size[a] + kBlockVoxels - 1) / kBlockVoxels;
      blocks.spacing[int(a)] *= kBlockVoxels;
    }
    sum = weight = Volume<float>(blocks);
  }
};

/// How the steps are smoothed along the surface: by the Gaussian that noise asks for, and in part
/// by a wide one where the image holds more than noise beside the model.
struct Windows {
  double narrow_variance;  ///< [voxels^2]
  std::vector<float> narrow, wide = sampled_gaussian(kWidestWindow);
  CoarseField wide_part;  ///< in [0, 1]

  Windows(double noise_share, const VolumeGeometry& voxels)
      : narrow_variance(
            std::clamp(noise_share / kNoiseOfOneVoxel, kNarrowestWindow, kWidestWindow)),
        narrow(sampled_gaussian(narrow_variance)),
        wide_part(Volume<float>(Misfit(voxels).sum.geometry, 1.0f),
                  {kBlockVoxels, kBlockVoxels, kBlockVoxels}) {}
};

/// The work on one brick, and its memory.
class BrickFit {
 public:
  BrickFit(const Volume<float>& phi, const FineGrid& fine, const EdgeModel& model,
           const BlurKernels& blur, const Windows& windows)
      : phi_(phi), fine_(fine), model_(model), blur_(blur), windows_(windows) {}

  /// The shift [mm] at the voxels of a brick and one beyond along each axis, the blur's sums, and
  /// the misfit in the brick's own blocks.
  std::vector<float> run(const Brick& brick, BlurSums& sums, Misfit& misfit) {
    read_wide_part(brick);
    const std::size_t reach = is_wide_ ? windows_.wide.size() : windows_.narrow.size();
    const int border = longest_reach(blur_) + int(reach) + 1;
    const Brick wider{brick.first, {brick.size[0] + 1, brick.size[1] + 1, brick.size[2] + 1}};
    gather(distance_, phi_, fine_.ratio, wider, border);
    part_inside(share_, distance_, model_.image.geometry.spacing);
    for (int axis = 0; axis < 3; ++axis) convolve(share_, blur_[std::size_t(axis)], axis, scratch_);
    explain(brick, sums, misfit);
    if (is_wide_ && is_narrow_) {
      wide_pull_ = pull_;
      wide_hold_ = hold_;
      look_through(windows_.wide, wide_pull_, wide_hold_);
    }
    look_through(is_narrow_ ? windows_.narrow : windows_.wide, pull_, hold_);
    return shifts(brick);
  }

 private:
  void read_wide_part(const Brick& brick);
  void explain(const Brick& brick, BlurSums& sums, Misfit& misfit);
  void look_through(const std::vector<float>& window, Patch& pull, Patch& hold) {
    for (int axis = 0; axis < 3; ++axis) {
      convolve(pull, window, axis, scratch_);
      convolve(hold, window, axis, scratch_);
    }
  }
  [[nodiscard]] std::vector<float> shifts(const Brick& brick) const;

  const Volume<float>& phi_;
  const FineGrid& fine_;
  const EdgeModel& model_;
  const BlurKernels& blur_;
  const Windows& windows_;
  bool is_wide_ = false, is_narrow_ = true;  ///< windows that have a part
  std::vector<float> wide_part_;             ///< as the shifts
  Patch distance_, share_, pull_, hold_, wide_pull_, wide_hold_;
  std::vector<float> scratch_;
};

void BrickFit::read_wide_part(const Brick& brick) {
  const int width = brick.size[0] + 1;
  wide_part_.resize(std::size_t(width * (brick.size[1] + 1) * (brick.size[2] + 1)));
  float* row = wide_part_.data();
  for (int k = 0; k <= brick.size[2]; ++k)
    for (int j = 0; j <= brick.size[1]; ++j, row += width)
      windows_.wide_part.row(brick.first[0], brick.first[1] + j, brick.first[2] + k, width, row);
  is_wide_ = std::any_of(wide_part_.begin(), wide_part_.end(), [](float w) { return w > 0.0f; });
  is_narrow_ = std::any_of(wide_part_.begin(), wide_part_.end(), [](float w) { return w < 1.0f; });
}

void BrickFit::explain(const Brick& brick, BlurSums& sums, Misfit& misfit) {
  const auto is_own = [&](int voxel, std::size_t axis) {
    return voxel >= brick.first[axis] && voxel < brick.first[axis] + brick.size[axis];
  };
  const int ni = share_.size[0], nj = share_.size[1], nk = share_.size[2];
  const auto& grid = model_.image.geometry;
  const Vec3T<float> h{float(grid.spacing.x), float(grid.spacing.y), float(grid.spacing.z)};
  pull_.resize(share_.first, share_.size);
  hold_.resize(share_.first, share_.size);
  const int left = std::max(share_.first[0], 0);
  const int width = std::min(share_.first[0] + ni, grid.size[0]) - left;
  std::vector<float> lumen(std::size_t(std::max(width, 0))), background(lumen.size()),
      lift(lumen.size());
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
          model_.levels.lift.row(left, vj, vk, width, lift.data());
          has_levels = true;
        }
        const float b = background[std::size_t(vi - left)];
        const float contrast = std::max({lumen[std::size_t(vi - left)] - b, model_.least_contrast,
                                         2.0f * (model_.intensity_min - b)});
        // What lies behind a wall that was put in for the background is as dark as that.
        const bool is_lifted = lift[std::size_t(vi - left)] > kLifted * contrast;
        const float value =
            is_lifted ? std::max(model_.image.values[v], b) : model_.image.values[v];
        const float e = std::clamp((value - b) / contrast - m[i], -kMostResidual, kMostResidual);
        pull_.row(j, k)[i] = std::sqrt(squared) * e;
        hold_.row(j, k)[i] = squared;
        if (!is_own(vi, 0) || !is_own(vj, 1) || !is_own(vk, 2)) continue;
        const std::size_t block =
            misfit.sum.geometry.offset(vi / kBlockVoxels, vj / kBlockVoxels, vk / kBlockVoxels);
        misfit.sum.values[block] += squared * e * e;
        misfit.weight.values[block] += squared;
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

std::vector<float> BrickFit::shifts(const Brick& brick) const {
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
  std::vector<float> shift(wide_part_.size());
  std::size_t n = 0;
  for (int k = 0; k <= brick.size[2]; ++k)
    for (int j = 0; j <= brick.size[1]; ++j) {
      const int vi = brick.first[0], vj = brick.first[1] + j, vk = brick.first[2] + k;
      const float *pulls = pull_.at(vi, vj, vk), *holds = hold_.at(vi, vj, vk);
      const bool is_mixed = is_wide_ && is_narrow_;
      const float* wide_pulls = is_mixed ? wide_pull_.at(vi, vj, vk) : nullptr;
      const float* wide_holds = is_mixed ? wide_hold_.at(vi, vj, vk) : nullptr;
      for (int i = 0; i <= brick.size[0]; ++i, ++n) {
        float pull = pulls[i], hold = holds[i];
        if (is_mixed) {
          pull += wide_part_[n] * (wide_pulls[i] - pull);
          hold += wide_part_[n] * (wide_holds[i] - hold);
        }
        shift[n] = std::clamp(pull / (hold + least), -most, most);
      }
    }
  return shift;
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
    blur.sd_voxels[a] = std::sqrt(
        std::clamp(better, kLeastBlurVoxels * kLeastBlurVoxels, kMostBlurVoxels * kMostBlurVoxels));
    blur.is_told = true;
  }
}

/// What the model leaves unexplained beyond the noise counts as noise of its own. Beginning with
/// the widest, a place's window narrows as far as its steps bring the model nearer to the image:
/// nothing is followed that the model does not know (clipped values, walls that touch).
CoarseField wide_part_for(Misfit misfit, const Windows& windows, double noise_share) {
  constexpr double kCertain = 1.25;  // times the noise: less may be chance
  const double reach = mean_spacing(misfit.sum.geometry);
  const Volume<float> sum = smooth(misfit.sum, reach), weight = smooth(misfit.weight, reach);
  for (std::size_t v = 0; v < sum.values.size(); ++v) {
    const double found =
        weight.values[v] > 0.0f ? std::sqrt(double(sum.values[v] / weight.values[v])) : 0.0;
    const double part = (found / kNoiseOfOneVoxel - windows.narrow_variance) /
                        std::max(kWidestWindow - windows.narrow_variance, 1e-3);
    misfit.sum.values[v] =
        found > kCertain * noise_share ? float(std::clamp(part, 0.0, 1.0)) : 0.0f;
  }
  return {std::move(misfit.sum), {kBlockVoxels, kBlockVoxels, kBlockVoxels}};
}

bool has_wide_part(const Windows& windows, const Brick& brick) {
  std::vector<float> part(std::size_t(brick.size[0]));
  for (int k = 0; k < brick.size[2]; ++k)
    for (int j = 0; j < brick.size[1]; ++j) {
      windows.wide_part.row(brick.first[0], brick.first[1] + j, brick.first[2] + k, brick.size[0],
                            part.data());
      if (*std::max_element(part.begin(), part.end()) > 0.0f) return true;
    }
  return false;
}

/// Takes roughness finer than a voxel off the boundary where the wide window is used; what that
/// shrinks, the next step gives back.
void smooth_unexplained(Volume<float>& phi, const FineGrid& fine, const std::vector<Brick>& bricks,
                        const Windows& windows, float band) {
  constexpr double kVariance = 0.25;  // [voxels^2]
  const auto& parts = windows.wide_part.coarse().values;
  if (*std::max_element(parts.begin(), parts.end()) <= 0.0f) return;
  BlurKernels kernels;
  int border = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    kernels[a] = sampled_gaussian(kVariance * fine.ratio[a] * fine.ratio[a]);
    border = std::max(border, int(kernels[a].size()));
  }
  const auto fine_brick = [&](const Brick& coarse) {
    Brick brick;
    for (std::size_t a = 0; a < 3; ++a) {
      brick.first[a] = coarse.first[a] * fine.ratio[a];
      brick.size[a] =
          std::min(coarse.size[a] * fine.ratio[a], phi.geometry.size[a] - brick.first[a]);
    }
    return brick;
  };
  std::vector<Patch> smoothed(bricks.size());  // all of them before one is changed
  parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
    const Brick& coarse = bricks[std::size_t(b)];
    if (!has_wide_part(windows, coarse)) return;
    Patch& patch = smoothed[std::size_t(b)];
    std::vector<float> scratch;
    gather(patch, phi, {1, 1, 1}, fine_brick(coarse), border);
    for (int axis = 0; axis < 3; ++axis) convolve(patch, kernels[std::size_t(axis)], axis, scratch);
  });
  parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
    const Brick& coarse = bricks[std::size_t(b)];
    const Patch& patch = smoothed[std::size_t(b)];
    if (patch.values.empty()) return;
    const Brick brick = fine_brick(coarse);
    std::vector<float> part(std::size_t(coarse.size[0]));
    for (int k = 0; k < brick.size[2]; ++k)
      for (int j = 0; j < brick.size[1]; ++j) {
        windows.wide_part.row(coarse.first[0], coarse.first[1] + j / fine.ratio[1],
                              coarse.first[2] + k / fine.ratio[2], coarse.size[0], part.data());
        float* row = &phi.at(brick.first[0], brick.first[1] + j, brick.first[2] + k);
        const float* to = patch.at(brick.first[0], brick.first[1] + j, brick.first[2] + k);
        for (int i = 0; i < brick.size[0]; ++i)
          if (std::abs(row[i]) < band)
            row[i] += part[std::size_t(i / fine.ratio[0])] * (to[i] - row[i]);
      }
  });
}

}  // namespace

void fit_edges(Volume<float>& phi, const FineGrid& fine, const EdgeModel& model, Blur& blur,
               int steps) {
  const VolumeGeometry& voxels = model.image.geometry;
  const auto band = float(kMovedVoxels * voxels.longest_spacing());
  Windows windows(model.noise_share, voxels);
  const auto edge = float(voxels.longest_spacing());
  // No step comes to others: each moves the boundary by part of a voxel.
  const auto candidates =
      bricks_at_boundary(phi, fine, voxels, 1.0f + float(kMostShift * std::max(steps - 1, 0)));
  for (int step = 0; step < steps; ++step) {
    std::vector<Brick> bricks;
    for (const Brick& brick : candidates)
      if (is_at_boundary(phi, fine, brick, edge)) bricks.push_back(brick);
    if (step > 0) smooth_unexplained(phi, fine, bricks, windows, band);
    const auto kernels = blur_kernels(blur);
    std::vector<std::vector<float>> shift(bricks.size());
    std::vector<BlurSums> sums(bricks.size());
    Misfit misfit(voxels);
    parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
      const auto n = std::size_t(b);
      BrickFit fit(phi, fine, model, kernels, windows);
      shift[n] = fit.run(bricks[n], sums[n], misfit);
    });
    parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
      move(phi, fine, bricks[std::size_t(b)], shift[std::size_t(b)], band);
    });
    windows.wide_part = wide_part_for(std::move(misfit), windows, model.noise_share);
    BlurSums total;
    for (const BlurSums& part : sums)
      for (int a = 0; a < 3; ++a) {
        total.right[a] += part.right[a];
        for (int c = 0; c < 3; ++c) total.matrix(a, c) += part.matrix(a, c);
      }
    if (!model.blur_is_known) improve_blur(blur, total, voxels.spacing);
  }
}

}  // namespace angio::segmentation::detail
