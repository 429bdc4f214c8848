#include "segmentation/detail/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "segmentation/detail/bridge.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/edge_fit.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/intensity_levels.hpp"
#include "segmentation/detail/signed_distance.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr int kRoughIterations = 2;
constexpr double kFirstBlurVoxels = 0.8;  ///< assumed until it is measured
constexpr double kRingMm = 3.0;           ///< of background looked at
constexpr double kRoughnessVoxels = 0.7;  ///< that noise leaves on the rough boundary
constexpr int kFitRounds = 2;             ///< between which intensities are told anew
constexpr int kFitSteps = 3;
constexpr double kFitVoxels = 2.5;             ///< of distance that the fit looks at
constexpr float kLeastShareOfContrast = 0.2f;  ///< of the contrast: T never goes below
constexpr double kVoxelBudget = 64e6;          ///< of the result
constexpr double kBesideVoxels = 1.5;  ///< of the tree: may be lumen below the level of blood
constexpr float kPeakShare = 0.7f;     ///< T stays below this share of the local peak

/// The highest value within one voxel.
Volume<float> local_peak(const Volume<float>& volume) {
  const auto [ni, nj, nk] = volume.geometry.size;
  Volume<float> peak(volume.geometry);
  parallel_for(nk, [&, ni = ni, nj = nj, nk = nk](std::ptrdiff_t slice) {
    const auto k = int(slice);
    auto highest = std::vector<float>(static_cast<std::size_t>(ni));  // over the rows beside
    for (int j = 0; j < nj; ++j) {
      std::copy_n(&volume.at(0, j, k), ni, highest.begin());
      for (int c = std::max(k - 1, 0); c <= std::min(k + 1, nk - 1); ++c)
        for (int b = std::max(j - 1, 0); b <= std::min(j + 1, nj - 1); ++b) {
          const float* row = &volume.at(0, b, c);
          for (std::size_t i = 0; i < highest.size(); ++i)
            highest[i] = std::max(highest[i], row[i]);
        }
      float* out = &peak.at(0, j, k);
      for (int i = 0; i < ni; ++i)
        out[i] = std::max({highest[std::size_t(std::max(i - 1, 0))], highest[std::size_t(i)],
                           highest[std::size_t(std::min(i + 1, ni - 1))]});
    }
  });
  return peak;
}

/// -F: negative where the voxel is more than half lumen.
/// @param from_tree  distance [mm]
Volume<float> level_function(const BoundaryInput& input, const Volume<float>& peak,
                             const IntensityLevels& levels, const Volume<float>& from_tree,
                             const SegmentationOptions& options) {
  const Volume<float>& volume = input.denoised;
  const float least_blood = input.blood ? input.blood->half() : -1e30f;
  const auto beside = float(kBesideVoxels * mean_spacing(volume.geometry));
  const float least_contrast = 0.1f * (levels.lumen_overall - levels.background_overall);
  const auto lowest = float(options.intensity_min.value_or(-1e30));
  const auto highest = float(options.intensity_max.value_or(1e30));
  Volume<float> level(volume.geometry);
  const auto [ni, nj, nk] = volume.geometry.size;
  parallel_for(nk, [&, ni = ni, nj = nj](std::ptrdiff_t k) {
    const auto width = std::size_t(ni);
    std::vector<float> lumen(width), background(width);
    for (int j = 0; j < nj; ++j) {
      levels.lumen.row(j, int(k), ni, lumen.data());
      levels.background.row(j, int(k), ni, background.data());
      for (int i = 0; i < ni; ++i) {
        const float b = background[std::size_t(i)];
        const float contrast = std::max(lumen[std::size_t(i)] - b, least_contrast);
        const float half = b + 0.5f * contrast;
        const float below_peak = b + kPeakShare * (peak.at(i, j, int(k)) - b);
        const float threshold =
            std::max({std::min(half, below_peak), b + kLeastShareOfContrast * contrast, lowest});
        const float value = volume.at(i, j, int(k));
        float excess = (value - threshold) / contrast;
        if (value > highest) excess = -0.5f;
        if (value < least_blood && from_tree.at(i, j, int(k)) > beside)
          excess = std::min(excess, -0.1f);
        level.at(i, j, int(k)) = -std::clamp(excess, -1.0f, 1.0f);
      }
    }
  });
  return level;
}

/// Calls body(first, last) for the values of each slice.
template <class Body>
void for_each_slice(const VolumeGeometry& grid, const Body& body) {
  const std::size_t slice = grid.voxel_count() / std::size_t(grid.size[2]);
  parallel_for(grid.size[2],
               [&](std::ptrdiff_t k) { body(std::size_t(k) * slice, std::size_t(k + 1) * slice); });
}

/// Whether several pieces of the inside hold as much of the tree as is worth a bridge.
bool is_broken(const Pieces& inside, const Volume<std::uint8_t>& tree,
               const std::array<int, 3>& ratio, const Vec3& spacing, double least_mm3) {
  const auto overlap = tree_in_pieces(inside, tree, ratio);
  const double voxel = spacing.x * spacing.y * spacing.z;
  return std::count_if(overlap.begin(), overlap.end(), [&](std::size_t count) {
           return count > 0 && double(count) * voxel >= least_mm3;
         }) > 1;
}

/// What of the tree is worth a bridge [mm^3]. The tree is connected, and holds no noise: a thin
/// branch, of which the level leaves short pieces, is kept as a whole.
double least_part(const VolumeGeometry& voxels, const SegmentationOptions& options) {
  constexpr double kLeastVoxels = 6.0;
  const Vec3& h = voxels.spacing;
  return std::min(options.min_component_mm3, kLeastVoxels * h.x * h.y * h.z);
}

/// Turns other pieces than the tree's into outside, and closed holes into inside.
/// @param pieces      of the inside
/// @param ratio       steps of the level's grid for each voxel of the tree
/// @param tree        the piece with most of it stays
/// @param all_above   [mm^3] other pieces with as much of the tree in them stay too
void keep_tree_only(Volume<float>& level, const Pieces& pieces, const Volume<std::uint8_t>& tree,
                    const std::array<int, 3>& ratio, double all_above) {
  const auto overlap = tree_in_pieces(pieces, tree, ratio);
  const Vec3& h = level.geometry.spacing;
  std::vector<bool> kept;
  for (std::size_t count : overlap) kept.push_back(double(count) * h.x * h.y * h.z > all_above);
  kept[std::size_t(std::max_element(overlap.begin(), overlap.end()) - overlap.begin())] = true;
  const auto change = [&](const Pieces::Run& run, const auto& to) {
    for (int i = run.first; i < run.last; ++i) {
      float& value = level.at(i, run.j, run.k);
      value = to(value);
    }
  };
  for (const Pieces::Run& run : pieces.runs)
    if (!kept[std::size_t(run.label)]) change(run, [](float value) { return -value; });
  const Pieces holes = find_pieces_outside(level);
  const auto outside = std::max_element(holes.voxel_count.begin(), holes.voxel_count.end()) -
                       holes.voxel_count.begin();
  for (const Pieces::Run& run : holes.runs)
    if (run.label != outside) change(run, [](float value) { return -std::max(value, 1e-3f); });
}

/// Steps that keep the result's grid even along all axes, half the finest voxel edge wide if the
/// grid stays within a budget, so that narrow vessels keep their shape.
FineGrid fine_grid(const VolumeGeometry& voxels) {
  const Vec3& h = voxels.spacing;
  const double finest = std::min({h.x, h.y, h.z});
  FineGrid fine;
  for (double wanted : {0.5 * finest, finest}) {
    for (std::size_t a = 0; a < 3; ++a)
      fine.ratio[a] = std::max(1, int(std::lround(h[int(a)] / wanted)));
    if (double(fine.geometry(voxels).voxel_count()) <= kVoxelBudget) return fine;
  }
  return {};
}

/// The boundary to within a part of a voxel.
struct RoughBoundary {
  Volume<float> distance;           ///< [mm]
  Volume<std::uint8_t> is_foreign;  ///< voxels of other bright things
  std::vector<Vec3> bridges_lps_mm;
};

RoughBoundary rough_boundary(const BoundaryInput& input, const SegmentationOptions& options,
                             double all_above, double blur_voxels) {
  const double voxel = mean_spacing(input.image.geometry);
  const double edge = kEdgeBlurs * blur_voxels * voxel;
  const double reach = edge + kRingMm;
  const Volume<float> peak = local_peak(input.denoised);
  Volume<float> level(input.image.geometry);
  const VolumeGeometry& grid = input.image.geometry;
  for_each_slice(grid, [&](std::size_t first, std::size_t last) {
    for (std::size_t v = first; v < last; ++v)
      level.values[v] = input.tree.values[v] ? -0.5f : 0.5f;
  });
  RoughBoundary rough;
  const Volume<float> from_tree = signed_distance(std::move(level), reach);
  rough.distance = from_tree;
  for (int iteration = 0; iteration < kRoughIterations; ++iteration) {
    const Volume<float> share =
        blurred_share(rough.distance, {}, grid, {{blur_voxels, blur_voxels, blur_voxels}});
    const IntensityLevels levels =
        intensity_levels(input.denoised, rough.distance, share, edge, input.blood);
    level = level_function(input, peak, levels, from_tree, options);
    rough.bridges_lps_mm.clear();
    Pieces inside = find_pieces_inside(level);
    const double least = least_part(grid, options);
    if (is_broken(inside, input.tree, {1, 1, 1}, grid.spacing, least)) {
      rough.bridges_lps_mm = bridge_pieces(level, input.tree, least, input.are_several);
      inside = find_pieces_inside(level);
    }
    rough.is_foreign = Volume<std::uint8_t>(grid);
    for_each_slice(grid, [&](std::size_t first, std::size_t last) {
      for (std::size_t v = first; v < last; ++v)
        rough.is_foreign.values[v] = level.values[v] < 0.0f;
    });
    keep_tree_only(level, inside, input.tree, {1, 1, 1}, all_above);
    for_each_slice(grid, [&](std::size_t first, std::size_t last) {
      for (std::size_t v = first; v < last; ++v)
        rough.is_foreign.values[v] = rough.is_foreign.values[v] && level.values[v] >= 0.0f;
    });
    rough.distance = signed_distance(std::move(level), reach);
  }
  return rough;
}

/// The part of the voxels inside that have the highest value of all.
double share_at_highest(const Volume<float>& image, const Volume<float>& distance) {
  const float highest = *std::max_element(image.values.begin(), image.values.end());
  std::size_t inside = 0, at_highest = 0;
  for (std::size_t v = 0; v < image.values.size(); ++v) {
    if (distance.values[v] >= 0.0f) continue;
    ++inside;
    at_highest += image.values[v] == highest;
  }
  return inside > 0 ? double(at_highest) / double(inside) : 0.0;
}

/// Where a vessel is thinner than the smoothing, its axis stays inside.
bool is_ridge(const Volume<float>& distance, int i, int j, int k) {
  const float here = distance.at(i, j, k);
  int axes = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int a[3] = {axis == 0, axis == 1, axis == 2};
    if (!distance.geometry.contains(i - a[0], j - a[1], k - a[2]) ||
        !distance.geometry.contains(i + a[0], j + a[1], k + a[2]))
      continue;
    axes += here <= distance.at(i - a[0], j - a[1], k - a[2]) &&
            here <= distance.at(i + a[0], j + a[1], k + a[2]);
  }
  return axes >= 2;
}

/// The boundary without the roughness of noise; what the smoothing shrinks the fit gives back.
Volume<float> without_roughness(const Volume<float>& distance) {
  const double voxel = mean_spacing(distance.geometry);
  Volume<float> smoothed = smooth(distance, kRoughnessVoxels * voxel);
  const auto deep = float(-0.3 * voxel);
  parallel_for(distance.geometry.size[2], [&](std::ptrdiff_t slice) {
    const auto k = int(slice);
    for (int j = 0; j < distance.geometry.size[1]; ++j)
      for (int i = 0; i < distance.geometry.size[0]; ++i) {
        const float d = distance.at(i, j, k);
        if (d < 0.0f && smoothed.at(i, j, k) > deep && is_ridge(distance, i, j, k))
          smoothed.at(i, j, k) = std::min(smoothed.at(i, j, k), std::max(d, deep));
      }
  });
  return smoothed;
}

/// The fit may have closed a place that is too narrow for the grid.
/// @return the pieces of the inside
Pieces join_pieces(Volume<float>& phi, const FineGrid& fine, const Volume<std::uint8_t>& tree,
                   bool are_several, const SegmentationOptions& options, Boundary& boundary) {
  Pieces inside = find_pieces_inside(phi);
  const double least = least_part(tree.geometry, options);
  if (!is_broken(inside, tree, fine.ratio, phi.geometry.spacing, least)) return inside;
  const auto fine_tree = refine_mask(tree, phi.geometry, fine.ratio);
  for (const Vec3& place : bridge_pieces(phi, fine_tree, least, are_several))
    boundary.bridges_lps_mm.push_back(place);
  return find_pieces_inside(phi);
}

/// Whether a lumen is hardly wider than a voxel around a place: blur lets a narrower one come out
/// half as wide again.
bool is_thin_at(const Vec3& place_lps, const Volume<float>& level_set, const FineGrid& fine,
                double voxel_mm) {
  constexpr double kVoxels = 1.5;
  const Vec3 index = level_set.geometry.index_from_lps(place_lps);
  const int i = int(std::lround(index.x)), j = int(std::lround(index.y)),
            k = int(std::lround(index.z));
  float deepest = 0.0f;
  for (int c = -fine.ratio[2]; c <= fine.ratio[2]; ++c)
    for (int b = -fine.ratio[1]; b <= fine.ratio[1]; ++b)
      for (int a = -fine.ratio[0]; a <= fine.ratio[0]; ++a)
        if (level_set.geometry.contains(i + a, j + b, k + c))
          deepest = std::min(deepest, level_set.at(i + a, j + b, k + c));
  return -2.0 * double(deepest) < kVoxels * voxel_mm;
}

/// Moves a boundary, everywhere by the same way of half a step at most, until it holds the labels'
/// volume.
void match_volume(Volume<float>& distance, const Volume<std::uint8_t>& labels) {
  const auto most = float(0.5 * mean_spacing(distance.geometry));
  const double steps_per_voxel =
      std::pow(mean_spacing(labels.geometry) / mean_spacing(distance.geometry), 3.0);
  double wanted =
      steps_per_voxel * double(std::count(labels.values.begin(), labels.values.end(), 1));
  std::vector<float> near;
  for (const float d : distance.values) {
    if (d < -most)
      wanted -= 1.0;
    else if (d < most)
      near.push_back(d);
  }
  if (near.empty()) return;
  const auto place = std::clamp(wanted, 0.0, double(near.size() - 1));
  const auto zero = near.begin() + std::ptrdiff_t(place);
  std::nth_element(near.begin(), zero, near.end());
  const float shift = *zero;
  for (float& d : distance.values) d -= shift;
}

}  // namespace

Boundary find_boundary(const BoundaryInput& input, const SegmentationOptions& options,
                       const Progress& progress) {
  const VolumeGeometry& voxels = input.image.geometry;
  const double voxel = mean_spacing(voxels);
  const double widest = voxels.longest_spacing();
  const double all_above =
      input.are_several ? options.min_component_mm3 : std::numeric_limits<double>::infinity();
  const RoughBoundary rough = rough_boundary(input, options, all_above, kFirstBlurVoxels);
  progress.report(0.7, "finding the boundary");
  const FineGrid fine = fine_grid(voxels);
  Volume<float> phi =
      refine_near_zero(without_roughness(rough.distance), fine, float(kFitVoxels * widest));
  Boundary boundary;
  Blur blur;
  for (int round = 0; round < kFitRounds; ++round) {
    keep_distance_band(phi, kFitVoxels * voxel);
    const Volume<float> share = blurred_share(phi, fine, voxels, blur);
    const double sd = std::hypot(blur.sd_voxels.x, 0.3);
    const IntensityLevels levels =
        intensity_levels(input.image, rough.distance, share, kEdgeBlurs * sd * voxel, input.blood);
    const float least = 0.1f * (levels.lumen_overall - levels.background_overall);
    const EdgeModel model{input.image,       levels, rough.is_foreign,
                          input.noise_share, least,  float(options.intensity_min.value_or(-1e30))};
    fit_edges(phi, fine, model, blur, kFitSteps);
    boundary.lumen_intensity = double(levels.lumen_overall);
    boundary.background_intensity = double(levels.background_overall);
    progress.report(0.7 + 0.08 * (round + 1), "fitting the boundary");
  }
  boundary.bridges_lps_mm = rough.bridges_lps_mm;
  boundary.clipped_share = share_at_highest(input.image, rough.distance);
  const Pieces inside = join_pieces(phi, fine, input.tree, input.are_several, options, boundary);
  keep_tree_only(phi, inside, input.tree, fine.ratio, all_above);
  boundary.level_set = signed_distance(std::move(phi), kReachMm);
  // What the rough boundary had to be joined at, the fit may have found wide.
  std::erase_if(boundary.bridges_lps_mm, [&](const Vec3& place) {
    return !is_thin_at(place, boundary.level_set, fine, widest);
  });
  for (int a = 0; a < 3; ++a) boundary.blur_sd_mm[a] = blur.sd_voxels[a] * voxels.spacing[a];
  boundary.blur_is_told = blur.is_told;
  return boundary;
}

Volume<float> find_label_boundary(const Volume<std::uint8_t>& labels,
                                  const SegmentationOptions& options, const Progress& progress) {
  constexpr double kStepNoise = 0.29;  // deviation of a label from the part inside: 1 / sqrt(12)
  const VolumeGeometry& voxels = labels.geometry;
  const double widest = voxels.longest_spacing();
  Volume<float> image(voxels), level(voxels);
  for_each_slice(voxels, [&](std::size_t first, std::size_t last) {
    for (std::size_t v = first; v < last; ++v) {
      image.values[v] = labels.values[v] ? 1.0f : 0.0f;
      level.values[v] = 0.5f - image.values[v];
    }
  });
  const Volume<float> distance = signed_distance(std::move(level), 2.0 * kFitVoxels * widest);
  const FineGrid fine = fine_grid(voxels);
  Volume<float> phi =
      refine_near_zero(without_roughness(distance), fine, float(kFitVoxels * widest));
  VolumeGeometry one_block = voxels;
  one_block.size = {1, 1, 1};
  const IntensityLevels levels{{Volume<float>(one_block, 1.0f), voxels.size},
                               {Volume<float>(one_block, 0.0f), voxels.size},
                               {Volume<float>(one_block, 0.0f), voxels.size},
                               1.0f,
                               0.0f};
  const Volume<std::uint8_t> is_foreign(voxels, 0);
  EdgeModel model{image, levels, is_foreign, kStepNoise, 1.0f};
  model.blur_is_known = true;
  Blur none{{0.0, 0.0, 0.0}, true};
  for (int round = 0; round < kFitRounds; ++round) {
    keep_distance_band(phi, kFitVoxels * mean_spacing(voxels));
    fit_edges(phi, fine, model, none, kFitSteps);
    progress.report(0.4 + 0.2 * (round + 1), "smoothing labels");
  }
  Boundary boundary;
  join_pieces(phi, fine, labels, true, options, boundary);
  Volume<float> result = signed_distance(std::move(phi), kReachMm);
  match_volume(result, labels);
  return result;
}

}  // namespace angio::segmentation::detail
