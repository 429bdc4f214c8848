#include "segmentation/detail/bones.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "segmentation/detail/bodies.hpp"
#include "segmentation/detail/components.hpp"
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
constexpr double kLeastCortex = 300.0;  ///< [mm^3] in one piece: calcified plaque is smaller
constexpr double kUnevenShare = 0.1;    ///< of what is deep in a bone is even, at most,
constexpr double kEvenShare = 0.25;     ///< and in blood, at least
constexpr float kBloodShare = 0.7f;     ///< of the way from tissue to blood: organs are darker
constexpr double kOrgan = 5.0;          ///< [mm] depth of organs; what is less deep may be a vein
constexpr double kLightShare = 0.5;     ///< of what is deep in a wide vessel is as bright as blood,
constexpr double kMixedShare = 0.85;    ///< or even, as blood with less contrast is, and no organ
constexpr double kBloodyShare = 0.3;    ///< of what is even is brighter, where veins lie beside it
constexpr float kOtherBolus = 0.5f;  ///< of the contrast above blood: veins, where they outshine it
constexpr double kGlaringShare = 0.5;  ///< of what is deep in them
constexpr double kWide = 2.0;      ///< depths that tell: what is as deep and not even is no blood
constexpr double kEvenTube = 0.5;  ///< of a vessel's axis is even, at least
constexpr double kLeastOthers = 15.0;  ///< [mm] of tubes that may be vessels, beside those of bones
constexpr float kTrunkShare = 0.2f;    ///< of the contrast around blood's level: a trunk
constexpr double kMostAbove = 0.25;    ///< of a scan: blood, bones and organs with contrast
constexpr double kMarrow = 600.0;      ///< [mm^2] of a section, darker than half way to blood
constexpr double kLeastTrunk = 10.0;   ///< [mm]
constexpr double kMostKeptOut = 0.33;  ///< of a scan: in a plain one all flesh is bright
constexpr double kLeastLeft = 0.2;     ///< of the wide tubes of blood's level: not all are bone
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

/// Tubes that are wide enough to show whether they are even inside, with the means there.
std::vector<TubeAxis> wide_tubes(const std::vector<TubeAxis>& axes, const Evenness& evenness) {
  std::vector<TubeAxis> wide = parts_of(axes, [&](const TubeAxis& axis, std::size_t) {
    return axis.radius_mm >= evenness.depth_mm();
  });
  for (TubeAxis& axis : wide)
    std::transform(axis.voxels.begin(), axis.voxels.end(), axis.intensity.begin(),
                   [&](std::size_t v) { return evenness.mean.values[v]; });
  return wide;
}

std::vector<TubeAxis> even_parts(const std::vector<TubeAxis>& axes, const Evenness& evenness) {
  return parts_of(
      axes, [&](const TubeAxis& axis, std::size_t n) { return evenness.is_even(axis.voxels[n]); });
}

double length_of(const std::vector<TubeAxis>& axes) {
  double length = 0.0;
  for (const TubeAxis& axis : axes) length += axis.length_share * double(axis.voxels.size());
  return length;
}

/// The tubes that are no bones (find_bones): all where none that is left is brighter than tissue.
std::vector<TubeAxis> without_bones(const std::vector<TubeAxis>& axes, const Evenness& evenness,
                                    float tissue) {
  std::vector<TubeAxis> uneven, others;
  for (const TubeAxis& axis : axes) {
    const auto even = std::count_if(axis.voxels.begin(), axis.voxels.end(),
                                    [&](std::size_t v) { return evenness.is_even(v); });
    const bool is_uneven = axis.radius_mm >= evenness.depth_mm() &&
                           double(even) < kEvenTube * double(axis.voxels.size());
    (is_uneven ? uneven : others).push_back(axis);
  }
  const std::vector<TubeAxis> bright = parts_of(
      others, [&](const TubeAxis& axis, std::size_t n) { return axis.intensity[n] > tissue; });
  if (length_of(bright) < kLeastOthers) return axes;
  std::vector<std::pair<float, double>> intensity, contrast;
  for (const TubeAxis& axis : others)
    for (std::size_t n = 0; n < axis.voxels.size(); ++n) {
      intensity.emplace_back(axis.intensity[n], axis.length_share);
      contrast.emplace_back(axis.contrast[n], axis.length_share);
    }
  const float glaring =
      weighted_quantile(intensity, 0.5) + kOtherBolus * weighted_quantile(contrast, 0.5);
  for (TubeAxis& axis : uneven) {
    const auto above = std::count_if(axis.intensity.begin(), axis.intensity.end(),
                                     [&](float value) { return value > glaring; });
    if (2 * std::size_t(above) < axis.intensity.size()) others.push_back(std::move(axis));
  }
  return others;
}

/// The parts of wide tubes that are as bright as blood.
std::vector<TubeAxis> parts_at_level(const std::vector<TubeAxis>& wide, const BloodLevel& level) {
  return parts_of(wide, [&](const TubeAxis& axis, std::size_t n) {
    return std::abs(axis.intensity[n] - level.lumen) < kTrunkShare * level.contrast();
  });
}

/// What is inside a body.
struct Inside {
  std::size_t all = 0, bright = 0, deep = 0;  ///< voxels
  std::size_t glaring = 0, even = 0;          ///< of the deep ones
  std::size_t light = 0;                      ///< of the deep ones: as bright as blood,
  std::size_t bloody = 0;                     ///< and even
  /// @param depth_mm  of its deepest voxel
  [[nodiscard]] Tissue tissue(double depth_mm, const Evenness& evenness,
                              const BloodLevel& level) const {
    const auto is_part = [](std::size_t part, double share, std::size_t whole) {
      return double(part) > share * double(whole);
    };
    if (deep < kLeastVoxels) return Tissue::unknown;
    if (level.is_of_pools && is_part(glaring, kGlaringShare, deep)) return Tissue::other;
    const bool is_dark = !is_part(light, kLightShare, deep);
    if (depth_mm > kOrgan && is_dark && !is_part(even, kMixedShare, deep)) return Tissue::other;
    if (is_part(even, kEvenShare, deep))
      return is_part(bloody, kBloodyShare, even) ? Tissue::blood
             : depth_mm > kOrgan                 ? Tissue::other
                                                 : Tissue::unknown;
    if (is_part(even, kUnevenShare, deep)) return Tissue::unknown;
    return is_part(bright, kBrightShare, all) || depth_mm > kWide * evenness.depth_mm()
               ? Tissue::other
               : Tissue::unknown;
  }
};

/// What is as bright as cortex, in pieces as large as those of bones.
Volume<std::uint8_t> cortex_in(const Volume<float>& denoised, const BloodLevel& level) {
  const float bright = level.lumen + kBrightExcess * level.contrast();
  Volume<std::uint8_t> cortex(denoised.geometry);
  for (std::size_t v = 0; v < cortex.values.size(); ++v)
    cortex.values[v] = denoised.values[v] > bright;
  const Components pieces = label_components(cortex, Connectivity::faces);
  const Vec3& h = denoised.geometry.spacing;
  const double least = kLeastCortex / (h.x * h.y * h.z);
  for (std::size_t v = 0; v < cortex.values.size(); ++v)
    cortex.values[v] =
        cortex.values[v] != 0 && double(pieces.voxel_count[std::size_t(pieces.label[v])]) >= least;
  return cortex;
}

/// What each body is, shape [body_count + 1].
std::vector<Tissue> judge(const Bodies& bodies, const Volume<float>& depth,
                          const Volume<float>& denoised, const Evenness& evenness,
                          const BloodLevel& level, const SegmentationOptions& options) {
  const Volume<std::uint8_t> cortex = cortex_in(denoised, level);
  const float half = level.half();
  const float glaring = level.lumen + kOtherBolus * level.contrast();
  const float organ = level.tissue + kBloodShare * level.contrast();
  std::vector<Inside> inside(std::size_t(bodies.count()) + 1);
  for (std::size_t v = 0; v < bodies.label.size(); ++v) {
    if (bodies.label[v] == 0) continue;
    Inside& body = inside[std::size_t(bodies.label[v])];
    const bool is_deep = double(depth.values[v]) >= evenness.depth_mm();
    ++body.all;
    body.bright += cortex.values[v];
    body.deep += is_deep;
    body.glaring += is_deep && cortex.values[v] != 0 && denoised.values[v] > glaring;
    const bool is_light = evenness.mean.values[v] > organ;
    body.light += is_deep && is_light;
    if (!is_deep || !(denoised.values[v] > half) || !evenness.is_even(v)) continue;
    ++body.even;
    body.bloody += is_light;
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
  Bones none;
  none.tubes = axes;
  if (!rough.is_told) return none;
  const Evenness evenness = find_evenness(volume, rough);
  const std::vector<TubeAxis> wide = wide_tubes(axes, evenness);
  const std::vector<TubeAxis> even = even_parts(wide, evenness);
  const Vec3& h = volume.geometry.spacing;
  const double voxel_mm3 = h.x * h.y * h.z;
  const BloodLevel level = find_even_level(
      even, even_sample(evenness), voxel_mm3 * double(sample_step(volume.values.size())), rough);
  none.tubes = without_bones(axes, evenness, rough.tissue);
  if (!(level.contrast() > 3.0f * evenness.of_tissue)) return none;
  if (is_muscle(level, volume)) return none;

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
  const double scanned_mm3 = voxel_mm3 * double(volume.values.size());
  if (bone_mm3 < kLeastBone || bone_mm3 > kMostKeptOut * scanned_mm3) return none;
  const std::vector<TubeAxis> bloody = parts_at_level(wide, level);
  const std::vector<TubeAxis> left = parts_of(bloody, [&](const TubeAxis& axis, std::size_t n) {
    return bones.mask.values[axis.voxels[n]] == 0;
  });
  if (length_of(bloody) >= kLeastTrunk && length_of(left) < kLeastLeft * length_of(bloody))
    return none;
  bones.are_there = true;
  bones.tubes = std::move(none.tubes);
  bones.level = level;
  bones.warning = warning_of(bone_mm3, level.is_of_pools);
  add_shells(bones.mask, denoised, float(std::min(noise, 0.05 * double(level.contrast()))), above);
  bones.image_without = take_out(volume, bones.mask, level.half());
  bones.trunks = even_parts(bloody, evenness);
  // A spine beside it bends a wide vessel's axis away.
  if (length_of(bones.trunks) < kLeastTrunk) {
    const auto again = wide_tubes(find_tube_axes(bones.image_without), evenness);
    bones.trunks = even_parts(parts_at_level(again, level), evenness);
  }
  return bones;
}

}  // namespace angio::segmentation::detail
