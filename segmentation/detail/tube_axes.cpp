#include "segmentation/detail/tube_axes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/parallel.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/hessian.hpp"
#include "segmentation/detail/vesselness.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kLeastRadiusVoxels = 2.2;  ///< below it, blur takes part of the profile
constexpr double kWidestRadius = 15.0;      ///< [mm]
constexpr double kScaleRatio = 1.5;
constexpr float kRoundness = 2.5f;      ///< most of l1 / l2
constexpr float kStraightness = 0.35f;  ///< most of |l3 / l2|
constexpr float kOffAxis = 0.5f;        ///< [scales] most distance from the axis
constexpr float kLeastFilled = 0.6f;    ///< of the contrast that the shape must explain
constexpr double kLeastSpanRadii = 3.0;

/// The contrast of a blurred volume's voxel against places at a distance along the grid's axes.
float contrast_to_surroundings(const Volume<float>& volume, const std::array<int, 3>& voxel,
                               double distance_mm) {
  std::array<float, 6> around{};
  std::size_t n = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (int side : {-1, 1}) {
      auto place = voxel;
      const int step =
          std::max(1, int(std::lround(distance_mm / volume.geometry.spacing[int(axis)])));
      place[axis] = std::clamp(place[axis] + side * step, 0, volume.geometry.size[axis] - 1);
      around[n++] = volume.at(place[0], place[1], place[2]);
    }
  std::sort(around.begin(), around.end());
  return volume.at(voxel[0], voxel[1], voxel[2]) - 0.5f * (around[2] + around[3]);
}

/// The voxels of a scale's grid that lie on an axis; C is left in `contrast`.
Volume<std::uint8_t> axis_mask(const ScaleView& view, double sigma, Volume<float>& contrast) {
  const Volume<float>& u = view.smoothed;
  const auto scale = float(std::numbers::e * sigma * sigma);
  contrast = Volume<float>(u.geometry);
  Volume<float> l2(u.geometry);
  Volume<std::uint8_t> mask(u.geometry);
  parallel_for(u.geometry.size[2], [&](std::ptrdiff_t k) {
    RowEigenvalues eigenvalues(u.geometry.size[0]);
    for (int j = 0; j < u.geometry.size[1]; ++j) {
      const RowDifferences differences(u, j, int(k));
      differences.find(eigenvalues);
      for (int i = 0; i < u.geometry.size[0]; ++i) {
        const auto n = std::size_t(i);
        const Vec3T<float> l{eigenvalues.low[n], eigenvalues.middle[n], eigenvalues.high[n]};
        l2.at(i, j, int(k)) = l.y;
        if (!(l.y < 0.0f) || -l.x > kRoundness * -l.y || std::abs(l.z) > kStraightness * -l.y)
          continue;
        const auto g = differences.gradient(i);
        const float off_axis = kOffAxis * float(sigma) * -l.y;
        if (norm_squared(g) > off_axis * off_axis) continue;
        const float c = scale * -l.y;
        // A tube on its axis, blurred by its scale, keeps 1 - 1/e of its contrast.
        const float seen =
            contrast_to_surroundings(u, {i, j, int(k)}, 2.0 * std::numbers::sqrt2 * sigma);
        if (c < kLeastFilled * seen / 0.632f) continue;
        contrast.at(i, j, int(k)) = c;
        mask.at(i, j, int(k)) = 1;
      }
    }
  });
  const auto noise = float(kNoiseDeviations * robust_deviation(l2.values));
  for (std::size_t v = 0; v < mask.values.size(); ++v)
    if (-l2.values[v] <= noise) mask.values[v] = 0;
  return mask;
}

void add_axes(const Volume<float>& volume, double radius, std::vector<TubeAxis>& axes) {
  const double sigma = radius / std::numbers::sqrt2;
  const ScaleView view = view_at_scale(volume, sigma);
  Volume<float> contrast;
  const Pieces pieces = find_pieces(axis_mask(view, sigma, contrast), Connectivity::corners);
  const VolumeGeometry& grid = contrast.geometry;
  const Vec3& h = grid.spacing;
  std::vector<TubeAxis> found(std::size_t(pieces.count()) + 1);
  std::vector<std::pair<Vec3, Vec3>> bounds(found.size(),
                                            {{1e30, 1e30, 1e30}, {-1e30, -1e30, -1e30}});
  for (const Pieces::Run& run : pieces.runs)
    for (int i = run.first; i < run.last; ++i) {
      TubeAxis& axis = found[std::size_t(run.label)];
      const std::array<int, 3> place{i, run.j, run.k};
      std::array<int, 3> voxel{};
      for (std::size_t a = 0; a < 3; ++a) {
        voxel[a] =
            std::min(place[a] * view.factor[a] + view.factor[a] / 2, volume.geometry.size[a] - 1);
        bounds[std::size_t(run.label)].first[int(a)] =
            std::min(bounds[std::size_t(run.label)].first[int(a)], place[a] * h[int(a)]);
        bounds[std::size_t(run.label)].second[int(a)] =
            std::max(bounds[std::size_t(run.label)].second[int(a)], place[a] * h[int(a)]);
      }
      axis.voxels.push_back(volume.geometry.offset(voxel[0], voxel[1], voxel[2]));
      axis.contrast.push_back(contrast.at(i, run.j, run.k));
      axis.intensity.push_back(volume.at(voxel[0], voxel[1], voxel[2]));
    }
  for (std::size_t n = 1; n < found.size(); ++n) {
    if (distance(bounds[n].first, bounds[n].second) < kLeastSpanRadii * radius) continue;
    found[n].radius_mm = radius;
    found[n].length_share = h.x * h.y * h.z / (radius * radius);
    axes.push_back(std::move(found[n]));
  }
}

}  // namespace

std::vector<TubeAxis> find_tube_axes(const Volume<float>& volume) {
  std::vector<TubeAxis> axes;
  for (double radius = kLeastRadiusVoxels * mean_spacing(volume.geometry); radius < kWidestRadius;
       radius *= kScaleRatio)
    add_axes(volume, radius, axes);
  return axes;
}

}  // namespace angio::segmentation::detail
