#include "segmentation/detail/wide_parts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/seeds.hpp"
#include "segmentation/detail/signed_distance.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kAlongBranches = 0.25;  ///< of the ball's radius
constexpr double kGaps = 0.3;            ///< of it, half of the widest gap that is closed
constexpr double kReachMm = 5.0;         ///< to which the level set tells distances outside

double voxel_mm3(const VolumeGeometry& grid) {
  return grid.spacing.x * grid.spacing.y * grid.spacing.z;
}

Volume<std::uint8_t> inside_of(const Volume<float>& level_set) {
  Volume<std::uint8_t> mask(level_set.geometry, 0);
  std::transform(level_set.values.begin(), level_set.values.end(), mask.values.begin(),
                 [](float d) { return d < 0.0f; });
  return mask;
}

/// Makes the wide parts outside. @return how much was inside of them [mm^3]
double cut_wide_parts(double radius, Volume<float>& level_set) {
  const double gap = std::min(kGaps * radius, 0.8 * kReachMm);
  Volume<float> core = level_set;
  for (float& d : core.values) d -= float(gap);
  core = signed_distance(std::move(core), gap);
  for (float& d : core.values) d += float(gap + radius);
  if (std::none_of(core.values.begin(), core.values.end(), [](float d) { return d < 0.0f; }))
    return 0.0;
  const double cut = (1.0 + kAlongBranches) * radius;
  const Volume<float> from_core = signed_distance(std::move(core), cut + kReachMm);
  std::size_t taken = 0;
  for (std::size_t v = 0; v < level_set.values.size(); ++v) {
    const float outside = float(cut) - from_core.values[v];
    taken += level_set.values[v] < 0.0f && outside >= 0.0f;
    level_set.values[v] = std::max(level_set.values[v], outside);
  }
  return double(taken) * voxel_mm3(level_set.geometry);
}

/// The deepest place of each piece, LPS [mm].
std::vector<Vec3> deepest_places(const Components& pieces, const Volume<float>& level_set) {
  std::vector<std::size_t> deepest(pieces.voxel_count.size(), 0);
  for (std::size_t v = 0; v < pieces.label.size(); ++v) {
    std::size_t& best = deepest[std::size_t(pieces.label[v])];
    if (pieces.label[best] != pieces.label[v] || level_set.values[v] < level_set.values[best])
      best = v;
  }
  std::vector<Vec3> places;
  for (const std::size_t v : deepest) places.push_back(place_of_voxel(level_set.geometry, v));
  return places;
}

std::string text_of(const Vec3& place) {
  return "[" + format_number(place.x) + ", " + format_number(place.y) + ", " +
         format_number(place.z) + "]";
}

/// Where the largest pieces that are left out could have a seed; empty: there are none.
std::string tell_of_other_pieces(const Components& pieces, const std::vector<bool>& kept,
                                 const std::vector<Vec3>& deepest, double least_voxels) {
  constexpr std::size_t kTold = 6;
  std::vector<std::size_t> others;
  for (std::size_t p = 1; p < kept.size(); ++p)
    if (!kept[p] && double(pieces.voxel_count[p]) >= least_voxels) others.push_back(p);
  if (others.empty()) return {};
  std::stable_sort(others.begin(), others.end(), [&](std::size_t a, std::size_t b) {
    return pieces.voxel_count[a] > pieces.voxel_count[b];
  });
  std::string places;
  for (std::size_t n = 0; n < std::min(kTold, others.size()); ++n)
    places += (n > 0 ? ", " : "") + text_of(deepest[others[n]]);
  return std::to_string(others.size()) + (others.size() == 1 ? " other piece" : " other pieces") +
         " of what is narrow " + (others.size() == 1 ? "was" : "were") +
         " left out, the largest at " + places + " mm; segmentation.seeds_lps_mm chooses";
}

}  // namespace

void leave_out_wide_parts(const SegmentationOptions& options, Segmentation& segmentation) {
  if (options.max_diameter_mm <= 0.0) return;
  Volume<float> level_set = std::move(segmentation.level_set);
  const VolumeGeometry& grid = level_set.geometry;
  const std::string most = format_number(options.max_diameter_mm) + " mm";
  if (const double taken = cut_wide_parts(0.5 * options.max_diameter_mm, level_set); taken > 0.0)
    segmentation.warnings.push_back("what is wider than " + most + " was left out (" +
                                    format_number(taken / 1000.0) + " ml)");
  const Components pieces = label_components(inside_of(level_set), Connectivity::faces);
  if (pieces.count() == 0)
    throw InputError("nothing of the lumen is narrower than segmentation.max_diameter_mm (" + most +
                     "). Raise it");
  const std::vector<Vec3> deepest = deepest_places(pieces, level_set);
  std::vector<bool> kept(deepest.size(), false);
  if (options.seeds_lps_mm.empty()) {
    const auto& size = pieces.voxel_count;
    const auto largest = std::size_t(std::max_element(size.begin() + 1, size.end()) - size.begin());
    kept[largest] = true;
    segmentation.seeds_lps_mm = {deepest[largest]};
  }
  for (const Vec3& seed : options.seeds_lps_mm)
    kept[std::size_t(piece_at_seed(pieces, grid, seed))] = true;
  if (std::string told =
          tell_of_other_pieces(pieces, kept, deepest, options.min_component_mm3 / voxel_mm3(grid));
      !told.empty())
    segmentation.warnings.push_back(std::move(told));
  for (std::size_t v = 0; v < level_set.values.size(); ++v)
    if (!kept[std::size_t(pieces.label[v])]) level_set.values[v] = std::abs(level_set.values[v]);
  const VoxelBox box = bounding_box(inside_of(level_set), kReachMm);
  segmentation.level_set = signed_distance(crop(level_set, box), kReachMm);
  segmentation.mask = inside_of(segmentation.level_set);
}

}  // namespace angio::segmentation::detail
