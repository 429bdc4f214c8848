#include "segmentation/detail/plausibility.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/error.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/depth.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/tunnels.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kMostShare = 0.5;      ///< of the scanned volume
constexpr double kToldShare = 0.3;      ///< likewise
constexpr double kWidestArtery = 20.0;  ///< radius [mm]
constexpr double kWideVessel = 5.0;     ///< likewise: none that wide begins and ends in a scan

const char* const kAdvice =
    "give a region around the vessels, seeds in them or a least brightness between tissue and "
    "blood (segmentation.region_lps_mm, segmentation.seeds_lps_mm, segmentation.intensity_min)";

double volume_of(const VolumeGeometry& grid) {
  return double(grid.voxel_count()) * grid.spacing.x * grid.spacing.y * grid.spacing.z;
}

/// The share of what was scanned that voxels of a grid in it fill.
double share_of(std::ptrdiff_t voxels, const VolumeGeometry& grid, const VolumeGeometry& scanned) {
  return double(voxels) / double(grid.voxel_count()) * volume_of(grid) / volume_of(scanned);
}

std::ptrdiff_t count_of(const Volume<std::uint8_t>& mask) {
  return std::count_if(mask.values.begin(), mask.values.end(),
                       [](std::uint8_t voxel) { return voxel != 0; });
}

std::string in_percent(double share) { return format_number(std::round(100.0 * share)) + " %"; }

/// Whether the lumen reaches the border of what was scanned, to two voxels.
bool reaches_border(const Volume<float>& level_set, const VolumeGeometry& scanned) {
  constexpr double kNear = 2.0;
  const VolumeGeometry& grid = level_set.geometry;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        if (level_set.at(i, j, k) >= 0.0f) continue;
        const Vec3 at =
            scanned.index_from_lps(grid.lps_from_index({double(i), double(j), double(k)}));
        for (int axis = 0; axis < 3; ++axis)
          if (at[axis] < kNear || at[axis] > double(scanned.size[std::size_t(axis)] - 1) - kNear)
            return true;
      }
  return false;
}

/// A grid of blocks; set where any voxel of a block is.
Volume<std::uint8_t> any_of_blocks(const Volume<std::uint8_t>& mask,
                                   const std::array<int, 3>& factor) {
  const VolumeGeometry& fine = mask.geometry;
  VolumeGeometry grid = fine;
  for (std::size_t a = 0; a < 3; ++a) {
    grid.size[a] = (fine.size[a] + factor[a] - 1) / factor[a];
    grid.spacing[int(a)] *= factor[a];
  }
  Volume<std::uint8_t> coarse(grid, 0);
  for (int k = 0; k < fine.size[2]; ++k)
    for (int j = 0; j < fine.size[1]; ++j)
      for (int i = 0; i < fine.size[0]; ++i)
        if (mask.at(i, j, k)) coarse.at(i / factor[0], j / factor[1], k / factor[2]) = 1;
  return coarse;
}

}  // namespace

void refuse_flood(const Volume<std::uint8_t>& mask, const VolumeGeometry& scanned) {
  const double share = share_of(count_of(mask), mask.geometry, scanned);
  if (share > kMostShare)
    throw InputError("no vessel was found apart from the rest (" + in_percent(share) +
                     " of the volume would be lumen: the contrast between blood and tissue is not "
                     "clear, or the volume holds something else). Try to " +
                     kAdvice);
  const double blood = share * volume_of(scanned);
  if (blood > kMostBlood)
    throw InputError("the lumen would hold " + format_number(std::round(1e-5 * blood) / 10.0) +
                     " l, more than heart, lungs and all arteries do (about 1.5 l): bone or organs "
                     "were taken for vessels. Try to " +
                     kAdvice);
}

std::vector<std::string> check_plausibility(const Volume<float>& level_set,
                                            const VolumeGeometry& scanned) {
  const auto inside = std::count_if(level_set.values.begin(), level_set.values.end(),
                                    [](float d) { return d < 0.0f; });
  if (inside == 0)
    throw InputError(
        std::string("no vessel was found (what was brighter than tissue is bone, or too "
                    "thin to be measured). Try to ") +
        kAdvice);
  const double share = share_of(inside, level_set.geometry, scanned);
  std::vector<std::string> warnings;
  if (share > kToldShare)
    warnings.push_back(
        in_percent(share) +
        " of the volume is lumen (tissue may have been taken for it: look at it); if "
        "so, " +
        kAdvice);
  const auto deepest = std::min_element(level_set.values.begin(), level_set.values.end());
  if (double(*deepest) < -kWideVessel && !reaches_border(level_set, scanned))
    warnings.push_back(std::string(kDoubtfulLumen) + "it is up to " +
                       format_number(std::round(-20.0 * double(*deepest)) / 10.0) +
                       " mm wide and reaches the scan's border nowhere, which vessels of that "
                       "width do: it may be bowel with contrast medium, or another organ. "
                       "Look at it; if so, " +
                       kAdvice);
  if (double(*deepest) < -kWidestArtery) {
    const Vec3 place =
        place_of_voxel(level_set.geometry, std::size_t(deepest - level_set.values.begin()));
    warnings.push_back(
        "the lumen is " + format_number(-2.0 * double(*deepest)) + " mm wide around " +
        format_place(place) +
        ", as chambers of the heart are, or tissue, and arteries only where they "
        "are aneurysms; wide parts can be left out (segmentation.max_diameter_mm, 7 for "
        "coronaries, "
        "with a seed in one); or " +
        kAdvice);
  }
  return warnings;
}

void refuse_sponge(const Volume<std::uint8_t>& mask, const VolumeGeometry& scanned,
                   bool has_seeds) {
  constexpr double kShareOfSponge = 0.2;
  constexpr std::int64_t kTunnelsOfSponge = 1000, kTunnelsOfBone = 3000;
  const double share = share_of(count_of(mask), mask.geometry, scanned);
  const std::int64_t tunnels = least_tunnels(mask);
  const bool is_sponge = share > kShareOfSponge && tunnels > kTunnelsOfSponge;
  if (!is_sponge && (has_seeds || tunnels <= kTunnelsOfBone)) return;
  throw InputError(
      "no vessel was found apart from the rest (" + in_percent(share) +
      " of the volume would be lumen, with " + std::to_string(tunnels) +
      " holes through it, as tissue and bone have and no tree of vessels: the contrast between "
      "blood and tissue is not clear, or the scan is no angiography). Try to " +
      kAdvice);
}

void refuse_shell(const Volume<std::uint8_t>& mask) {
  constexpr double kWideHole = 4000.0;  // [mm^2] in a section: heart and arteries close around less
  constexpr double kMostInside = 3.0e5;  // [mm^3]: a brain has 1.2 l
  constexpr double kAnyHole = 1e9;       // [mm^2]
  const Volume<std::uint8_t> coarse = any_of_blocks(mask, block_size(mask.geometry, 1.0));
  const auto filled_up_to = [&](double most_mm2) {
    Volume<std::uint8_t> filled = coarse;
    fill_holes(filled, most_mm2);
    return count_of(filled);
  };
  const Vec3& h = coarse.geometry.spacing;
  const double inside = double(filled_up_to(kAnyHole) - filled_up_to(kWideHole)) * h.x * h.y * h.z;
  if (inside <= kMostInside) return;
  throw InputError("no vessel was found apart from the rest (what was found closes around " +
                   format_number(std::round(1e-5 * inside) / 10.0) +
                   " l, as a skull or skin does: bone or fat is brighter than the vessels, or the "
                   "scan is no angiography). Try to " +
                   kAdvice);
}

void refuse_crumb(const Volume<std::uint8_t>& mask, const VolumeGeometry& scanned) {
  constexpr double kBody = 150.0, kShort = 20.0;  // [mm]
  const VoxelBox box = bounding_box(mask, 0.0);
  double longest = 0.0;
  int across = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    longest = std::max(longest, box.size[a] * mask.geometry.spacing[int(a)]);
    across += scanned.size[a] * scanned.spacing[int(a)] >= kBody;
  }
  if (across < 2 || longest >= kShort) return;
  throw InputError("no vessel was found (what stands out most is " +
                   format_number(std::round(10.0 * longest) / 10.0) +
                   " mm long, in a scan of a body: calcium in a wall, or noise; the scan may have "
                   "no contrast medium). Try to " +
                   kAdvice);
}

std::string check_evenness(const Volume<float>& level_set, const Volume<float>& image) {
  constexpr float kToldSpread = 1.3f, kMostSpread = 1.9f;  // medians
  constexpr std::size_t kLeastVoxels = 200, kEnough = 100000;
  const auto deep = float(-0.7 * image.geometry.longest_spacing());
  std::vector<std::size_t> inside;
  for (std::size_t v = 0; v < level_set.values.size(); ++v)
    if (level_set.values[v] < deep) inside.push_back(v);
  if (inside.size() < kLeastVoxels) return {};
  std::vector<std::pair<float, double>> values;
  for (std::size_t n = 0; n < inside.size(); n += 1 + inside.size() / kEnough)
    values.emplace_back(float(interpolate(image, place_of_voxel(level_set.geometry, inside[n]))),
                        1.0);
  const float low = weighted_quantile(values, 0.1), middle = weighted_quantile(values, 0.5),
              high = weighted_quantile(values, 0.9);
  if (!(middle > 0.0f) || high - low < kToldSpread * middle) return {};
  const std::string what = "of the lumen a tenth is darker than " +
                           format_number(std::round(double(low))) + " and a tenth brighter than " +
                           format_number(std::round(double(high))) +
                           ", as in bone, where blood is of one brightness";
  if (high - low > kMostSpread * middle)
    throw InputError("no vessel was found apart from bone (" + what +
                     ": there is no contrast medium, or bone is brighter). Try to " + kAdvice);
  return kDoubtfulLumen + what + ". Look at it; if so, " + kAdvice;
}

std::string check_contrast(double lumen_intensity, const Volume<float>& scanned) {
  constexpr double kAir = -500.0, kLeast = -50.0, kMost = 90.0;  // [HU]
  const float lowest = *std::min_element(scanned.values.begin(), scanned.values.end());
  if (double(lowest) > kAir || lumen_intensity < kLeast || lumen_intensity > kMost) return {};
  return "the lumen is as bright as tissue without contrast medium (" +
         format_number(std::round(lumen_intensity)) +
         "; in CT blood with it is above 100): vessels of the lung may be seen, others hardly; "
         "check "
         "that the series was scanned with contrast";
}

}  // namespace angio::segmentation::detail
