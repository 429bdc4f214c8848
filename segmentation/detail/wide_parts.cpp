#include "segmentation/detail/wide_parts.hpp"

#include <algorithm>
#include <array>
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
constexpr double kGivenBack = 0.5;       ///< likewise, around the vessels that are kept

Volume<std::uint8_t> inside_of(const Volume<float>& level_set) {
  Volume<std::uint8_t> mask(level_set.geometry, 0);
  std::transform(level_set.values.begin(), level_set.values.end(), mask.values.begin(),
                 [](float d) { return d < 0.0f; });
  return mask;
}

std::size_t count_inside(const Volume<float>& level_set) {
  return std::size_t(std::count_if(level_set.values.begin(), level_set.values.end(),
                                   [](float d) { return d < 0.0f; }));
}

/// The lumen without what a ball fits into once gaps of 2 `gap` are closed, and what lies along its
/// branches.
Volume<float> without_wide_parts(const Volume<float>& level_set, double radius, double gap) {
  Volume<float> core = level_set;
  if (gap > 0.0) {
    for (float& d : core.values) d -= float(gap);
    core = signed_distance(std::move(core), gap);
  }
  for (float& d : core.values) d += float(gap + radius);
  if (count_inside(core) == 0) return level_set;
  const double cut = (1.0 + kAlongBranches) * radius;
  Volume<float> rest = signed_distance(std::move(core), cut + kReachMm);
  for (std::size_t v = 0; v < rest.values.size(); ++v)
    rest.values[v] = std::max(level_set.values[v], float(cut) - rest.values[v]);
  return rest;
}

/// Makes the pieces that are not kept outside.
void keep(const Components& pieces, const std::vector<bool>& kept, Volume<float>& level_set) {
  for (std::size_t v = 0; v < level_set.values.size(); ++v)
    if (!kept[std::size_t(pieces.label[v])]) level_set.values[v] = std::abs(level_set.values[v]);
}

/// What of a lumen lies within a reach of pieces of it, and hangs together with them.
/// @param pieces  a level set, negative inside
Volume<float> around_pieces(const Volume<float>& lumen, const Volume<float>& pieces, double reach) {
  Volume<float> rest = signed_distance(pieces, reach + kReachMm);
  for (std::size_t v = 0; v < rest.values.size(); ++v)
    rest.values[v] = std::max(lumen.values[v], rest.values[v] - float(reach));
  const Components parts = label_components(inside_of(rest), Connectivity::faces);
  std::vector<bool> kept(parts.voxel_count.size(), false);
  for (std::size_t v = 0; v < rest.values.size(); ++v)
    if (parts.label[v] > 0 && pieces.values[v] < 0.0f) kept[std::size_t(parts.label[v])] = true;
  keep(parts, kept, rest);
  return rest;
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

/// Where the vessels that are kept open into what was cut off: the widest places first.
/// @param before  1 inside, before the cut
std::string tell_of_mouths(const Volume<std::uint8_t>& before, const Volume<float>& level_set) {
  constexpr std::size_t kTold = 6;
  constexpr std::size_t kLeastVoxels = 4;
  const VolumeGeometry& grid = before.geometry;
  Volume<std::uint8_t> open(grid, 0);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        if (level_set.at(i, j, k) >= 0.0f) continue;
        for (const auto& [a, b, c] : std::array<std::array<int, 3>, 6>{
                 {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}}) {
          const int x = i + a, y = j + b, z = k + c;
          if (grid.contains(x, y, z) && before.at(x, y, z) != 0 && level_set.at(x, y, z) >= 0.0f)
            open.at(i, j, k) = 1;
        }
      }
  const Components mouths = label_components(open, Connectivity::corners);
  std::vector<Vec3> middle(mouths.voxel_count.size());
  for (std::size_t v = 0; v < open.values.size(); ++v)
    if (const auto m = std::size_t(mouths.label[v]); m > 0)
      middle[m] += place_of_voxel(grid, v) / double(mouths.voxel_count[m]);
  std::vector<std::size_t> order;
  for (std::size_t m = 1; m < middle.size(); ++m)
    if (mouths.voxel_count[m] >= kLeastVoxels) order.push_back(m);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return mouths.voxel_count[a] > mouths.voxel_count[b];
  });
  std::string places;
  for (std::size_t n = 0; n < std::min(kTold, order.size()); ++n)
    places += (n > 0 ? ", " : "") + text_of(middle[order[n]]);
  if (places.empty()) return {};
  return "what is left opens into what was left out at " + places +
         " mm, the widest first; --inlet says where blood comes in";
}

}  // namespace

void leave_out_wide_parts(const SegmentationOptions& options, Segmentation& segmentation) {
  if (options.max_diameter_mm <= 0.0) return;
  const double radius = 0.5 * options.max_diameter_mm;
  const Volume<float> lumen = std::move(segmentation.level_set);
  const VolumeGeometry& grid = lumen.geometry;
  const std::string most = format_number(options.max_diameter_mm) + " mm";
  Volume<float> narrow =
      without_wide_parts(lumen, radius, std::min(kGaps * radius, 0.8 * kReachMm));
  if (const std::size_t taken = count_inside(lumen) - count_inside(narrow); taken > 0)
    segmentation.warnings.push_back("what is wider than " + most + " was left out (" +
                                    format_number(double(taken) * voxel_volume(grid) / 1000.0) +
                                    " ml)");
  const Components pieces = label_components(inside_of(narrow), Connectivity::faces);
  if (pieces.count() == 0)
    throw InputError("nothing of the lumen is narrower than segmentation.max_diameter_mm (" + most +
                     "). Raise it");
  const std::vector<Vec3> deepest = deepest_places(pieces, narrow);
  std::vector<bool> kept(deepest.size(), false);
  if (options.seeds_lps_mm.empty()) {
    const auto& size = pieces.voxel_count;
    const auto largest = std::size_t(std::max_element(size.begin() + 1, size.end()) - size.begin());
    kept[largest] = true;
    segmentation.seeds_lps_mm = {deepest[largest]};
  }
  for (const Vec3& seed : options.seeds_lps_mm)
    kept[std::size_t(piece_at_seed(pieces, grid, seed))] = true;
  if (std::string told = tell_of_other_pieces(pieces, kept, deepest,
                                              options.min_component_mm3 / voxel_volume(grid));
      !told.empty())
    segmentation.warnings.push_back(std::move(told));
  keep(pieces, kept, narrow);
  narrow = around_pieces(without_wide_parts(lumen, radius, 0.0), narrow, kGivenBack * radius);
  if (std::string told = tell_of_mouths(inside_of(lumen), narrow); !told.empty())
    segmentation.warnings.push_back(std::move(told));
  const VoxelBox box = bounding_box(inside_of(narrow), kReachMm);
  segmentation.level_set = signed_distance(crop(narrow, box), kReachMm);
  segmentation.mask = inside_of(segmentation.level_set);
}

}  // namespace angio::segmentation::detail
