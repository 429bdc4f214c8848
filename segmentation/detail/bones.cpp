#include "segmentation/detail/bones.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "segmentation/detail/bodies.hpp"
#include "segmentation/detail/depth.hpp"
#include "segmentation/detail/evenness.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/seeds.hpp"
#include "segmentation/detail/take_out.hpp"
#include "segmentation/detail/vessel_tree.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kNeckShare = 0.75;  ///< of the less deep of two bodies: a narrower way is a neck
constexpr float kBrightExcess = 0.35f;  ///< of the contrast above blood: as cortex is
constexpr double kBrightShare = 0.1;    ///< of a bone
constexpr double kUnevenShare = 0.1;    ///< of what is deep in a bone is even, at most,
constexpr double kEvenShare = 0.25;     ///< and in blood, at least
constexpr float kBloodShare = 0.7f;     ///< of the way from tissue to blood: organs are darker
constexpr float kOtherBolus = 0.5f;  ///< of the contrast above blood: veins, where they outshine it
constexpr double kWide = 2.0;        ///< depths that tell: what is as deep and not even is no blood
constexpr float kTrunkShare = 0.2f;  ///< of the contrast around blood's level: a trunk
constexpr double kMostAbove = 0.25;  ///< of a scan: blood, bones and organs with contrast
constexpr double kMarrow = 600.0;    ///< [mm^2] of a section, darker than half way to blood
constexpr double kLeastTrunk = 10.0;      ///< [mm]
constexpr std::size_t kLeastVoxels = 27;  ///< deep ones that tell
constexpr double kLeastBone = 5000.0;     ///< [mm^3]

/// Each how many voxels are asked for a sample of the volume.
std::size_t sample_step(std::size_t voxel_count) {
  constexpr std::size_t kSampleCount = 2000000;
  return std::max<std::size_t>(1, voxel_count / kSampleCount);
}

/// Means of even neighbourhoods, from all over the volume.
std::vector<float> even_sample(const Evenness& evenness) {
  const std::size_t count = evenness.mean.values.size(), step = sample_step(count);
  std::vector<float> sample;
  for (std::size_t v = 0; v < count; v += step)
    if (evenness.is_even(v)) sample.push_back(evenness.mean.values[v]);
  return sample;
}

/// The parts of wide tubes that are even inside, with the means there.
std::vector<TubeAxis> even_parts(const std::vector<TubeAxis>& axes, const Evenness& evenness) {
  std::vector<TubeAxis> even = parts_of(axes, [&](const TubeAxis& axis, std::size_t n) {
    return axis.radius_mm >= evenness.depth_mm() && evenness.is_even(axis.voxels[n]);
  });
  for (TubeAxis& axis : even)
    std::transform(axis.voxels.begin(), axis.voxels.end(), axis.intensity.begin(),
                   [&](std::size_t v) { return evenness.mean.values[v]; });
  return even;
}

double length_of(const std::vector<TubeAxis>& axes) {
  double length = 0.0;
  for (const TubeAxis& axis : axes) length += axis.length_share * double(axis.voxels.size());
  return length;
}

std::vector<TubeAxis> trunks_among(const std::vector<TubeAxis>& even, const BloodLevel& level) {
  return parts_of(even, [&](const TubeAxis& axis, std::size_t n) {
    return std::abs(axis.intensity[n] - level.lumen) < kTrunkShare * level.contrast();
  });
}

/// What is inside a body.
struct Inside {
  std::size_t all = 0, bright = 0, deep = 0, even = 0;  ///< voxels; even ones of the deep ones
  double deep_sum = 0.0, even_sum = 0.0;                ///< of the values of these two
  /// @param depth_mm  of its deepest voxel
  [[nodiscard]] Tissue tissue(double depth_mm, const Evenness& evenness,
                              const BloodLevel& level) const {
    const auto is_part = [](std::size_t part, double share, std::size_t whole) {
      return double(part) > share * double(whole);
    };
    if (deep < kLeastVoxels) return Tissue::unknown;
    const double most = double(level.lumen + kOtherBolus * level.contrast());
    if (level.is_of_pools && deep_sum > most * double(deep)) return Tissue::other;
    if (is_part(even, kEvenShare, deep)) {
      const double least = double(level.tissue + kBloodShare * level.contrast());
      return even_sum > least * double(even) ? Tissue::blood : Tissue::other;
    }
    if (is_part(even, kUnevenShare, deep)) return Tissue::unknown;
    return is_part(bright, kBrightShare, all) || depth_mm > kWide * evenness.depth_mm()
               ? Tissue::other
               : Tissue::unknown;
  }
};

/// What each body is, shape [body_count + 1].
std::vector<Tissue> judge(const Bodies& bodies, const Volume<float>& depth,
                          const Volume<float>& denoised, const Evenness& evenness,
                          const BloodLevel& level, const SegmentationOptions& options) {
  const float half = level.half(), bright = level.lumen + kBrightExcess * level.contrast();
  std::vector<Inside> inside(std::size_t(bodies.count()) + 1);
  for (std::size_t v = 0; v < bodies.label.size(); ++v) {
    if (bodies.label[v] == 0) continue;
    Inside& body = inside[std::size_t(bodies.label[v])];
    const bool is_deep = double(depth.values[v]) >= evenness.depth_mm();
    ++body.all;
    body.bright += denoised.values[v] > bright;
    body.deep += is_deep;
    body.deep_sum += is_deep ? double(denoised.values[v]) : 0.0;
    if (!is_deep || !(denoised.values[v] > half) || !evenness.is_even(v)) continue;
    ++body.even;
    body.even_sum += double(evenness.mean.values[v]);
  }
  std::vector<Tissue> tissues(inside.size(), Tissue::unknown);
  for (std::size_t b = 1; b < inside.size(); ++b)
    tissues[b] = inside[b].tissue(double(bodies.depth_mm[b]), evenness, level);
  for (const Vec3& seed : options.seeds_lps_mm) {
    const auto v = voxel_at(depth.geometry, seed);
    if (v && bodies.label[*v] > 0) tissues[std::size_t(bodies.label[*v])] = Tissue::blood;
  }
  spread(bodies, tissues);
  return tissues;
}

std::string warning_of(double volume_mm3, bool is_of_pools) {
  const std::string what =
      is_of_pools ? "bone and vessels that are far brighter than most of the blood (veins before "
                    "their contrast has mixed?)"
                  : "bone and organs that are about as bright as the vessels";
  return format_number(std::round(volume_mm3 / 1000.0)) + " ml of " + what +
         " were kept out; if vessel is missing, give a seed in it or set "
         "segmentation.exclude_bone = false";
}

}  // namespace

bool is_muscle(const BloodLevel& level, const Volume<float>& volume) {
  const auto above = std::count_if(volume.values.begin(), volume.values.end(),
                                   [&](float value) { return value > level.half(); });
  return level.is_of_pools && double(above) > kMostAbove * double(volume.values.size());
}

Bones find_bones(const Volume<float>& volume, const std::vector<TubeAxis>& axes,
                 const SegmentationOptions& options) {
  const double noise = noise_deviation(volume);
  const BloodLevel rough = find_blood_level(axes, volume, noise);
  if (!rough.is_told) return {};
  const Evenness evenness = find_evenness(volume, rough);
  const std::vector<TubeAxis> even = even_parts(axes, evenness);
  const Vec3& h = volume.geometry.spacing;
  const double voxel_mm3 = h.x * h.y * h.z;
  const BloodLevel level = find_even_level(
      even, even_sample(evenness), voxel_mm3 * double(sample_step(volume.values.size())), rough);
  if (!(level.contrast() > 3.0f * evenness.of_tissue)) return {};
  if (is_muscle(level, volume)) return {};

  const Volume<float> denoised =
      smooth(volume, denoising_sigma(volume, noise, double(level.contrast())));
  Volume<std::uint8_t> above(volume.geometry);
  for (std::size_t v = 0; v < above.values.size(); ++v)
    above.values[v] = denoised.values[v] > level.half();
  Volume<std::uint8_t> filled = above;
  fill_holes(filled, kMarrow);
  const Volume<float> depth = depth_in(filled);
  const Bodies bodies = part_into_bodies(depth, evenness.depth_mm(), kNeckShare);
  const std::vector<Tissue> tissues = judge(bodies, depth, denoised, evenness, level, options);

  Bones bones;
  bones.mask = Volume<std::uint8_t>(volume.geometry);
  std::size_t count = 0;
  for (std::size_t v = 0; v < above.values.size(); ++v) {
    const Tissue tissue = tissues[std::size_t(bodies.label[v])];
    bones.mask.values[v] = tissue == Tissue::other;
    count += bones.mask.values[v] && above.values[v];
    above.values[v] = above.values[v] && tissue != Tissue::other;
  }
  const double bone_mm3 = double(count) * voxel_mm3;
  if (bone_mm3 < kLeastBone) return {};
  bones.are_there = true;
  bones.level = level;
  bones.warning = warning_of(bone_mm3, level.is_of_pools);
  add_shells(bones.mask, denoised, float(std::min(noise, 0.05 * double(level.contrast()))), above);
  bones.image_without = take_out(volume, bones.mask, level.half());
  bones.trunks = trunks_among(even, level);
  // A spine beside it bends a wide vessel's axis away.
  if (length_of(bones.trunks) < kLeastTrunk)
    bones.trunks = trunks_among(even_parts(find_tube_axes(bones.image_without), evenness), level);
  return bones;
}

}  // namespace angio::segmentation::detail
