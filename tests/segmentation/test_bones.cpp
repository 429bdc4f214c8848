#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "core/error.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/bodies.hpp"
#include "segmentation/detail/bones.hpp"
#include "segmentation/detail/depth.hpp"
#include "segmentation/detail/evenness.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/take_out.hpp"
#include "segmentation/segmentation.hpp"
#include "tests/segmentation/grids.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation {
namespace {

using namespace detail;
using test::for_each_voxel;
using test::grid_of;
using testing::Contains;
using testing::HasSubstr;

constexpr double kAorta = 8.0;                                         ///< radius [mm]
constexpr double kBloodOfTrunk = 350.0, kFlesh = 50.0, kFat = -100.0;  ///< [HU]

/// A body: fat with muscle, an aorta along z with a branch to the left, and a vertebra that it lies
/// on, cortex around marrow of struts; between them the mean of the marrow is that of blood.
struct BodyImage {
  Volume<float> volume;
  Volume<std::uint8_t> is_bone, is_blood;
};

BodyImage body_image(bool with_bone, double noise_sd, double blood = kBloodOfTrunk,
                     double slice_mm = 1.0) {
  const VolumeGeometry grid = grid_of({90, 90, 60}, {1.0, 1.0, slice_mm});
  BodyImage body{Volume<float>(grid), Volume<std::uint8_t>(grid), Volume<std::uint8_t>(grid)};
  std::mt19937 random(5);
  std::vector<float> struts(64 * 64 * 64);
  std::uniform_real_distribution<float> strut(100.0f, 600.0f);
  for (float& value : struts) value = strut(random);
  for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
    const double to_axis = std::hypot(p.x, p.y);
    const bool is_branch = std::hypot(p.y, p.z) < 3.0 && p.x < 0.0 && p.x > -35.0;
    const bool is_blood = to_axis < kAorta || is_branch;
    // Behind the aorta, 30 mm wide.
    const double face = kAorta + 1.0 + std::max(0.0, p.z / 2.5);  // fat between, of 1 to 13 mm
    const double in_bone = std::min({15.0 - std::abs(p.x), p.y - face, 38.0 - p.y});
    const bool is_bone = with_bone && !is_blood && in_bone > 0.0;
    const auto cell = [](double x) { return std::size_t(std::floor(x / 2.5) + 32.0); };
    const double marrow = struts[(cell(p.x) * 64 + cell(p.y)) * 64 + cell(p.z)];
    body.is_bone.values[v] = is_bone;
    body.is_blood.values[v] = is_blood;
    body.volume.values[v] = float(is_blood                      ? blood
                                  : is_bone                     ? (in_bone < 2.0 ? 750.0 : marrow)
                                  : std::hypot(p.x, p.y) < 38.0 ? kFlesh
                                                                : kFat);
  });
  body.volume = smooth(body.volume, 0.7);
  std::normal_distribution<float> noise(0.0f, float(noise_sd));
  for (float& value : body.volume.values) value += noise(random);
  return body;
}

/// Which part of the voxels of one mask are in another.
double part_in(const Volume<std::uint8_t>& mask, const Volume<std::uint8_t>& other) {
  double all = 0.0, both = 0.0;
  for (std::size_t v = 0; v < mask.values.size(); ++v) {
    all += mask.values[v] != 0;
    both += mask.values[v] != 0 && other.values[v] != 0;
  }
  return both / all;
}

TEST(Evenness, IsThatOfNoiseInBloodAndMoreInBone) {
  const BodyImage body = body_image(true, 15.0);
  BloodLevel level;
  level.lumen = float(kBloodOfTrunk);
  level.tissue = float(kFlesh);
  const Evenness evenness = find_evenness(body.volume, level);
  EXPECT_NEAR(evenness.of_tissue, 15.0, 3.0);
  Volume<std::uint8_t> even(body.volume.geometry);
  for (std::size_t v = 0; v < even.values.size(); ++v) even.values[v] = evenness.is_even(v);
  Volume<std::uint8_t> deep_bone = body.is_bone, deep_blood = body.is_blood;
  const Volume<float> in_bone = depth_in(body.is_bone), in_blood = depth_in(body.is_blood);
  for (std::size_t v = 0; v < even.values.size(); ++v) {
    deep_bone.values[v] = in_bone.values[v] > evenness.depth_mm();
    deep_blood.values[v] = in_blood.values[v] > evenness.depth_mm();
  }
  EXPECT_LT(part_in(deep_bone, even), 0.05);
  EXPECT_GT(part_in(deep_blood, even), 0.7);
}

TEST(Bones, AreToldFromTheVesselThatLiesOnThem) {
  for (const double noise : {5.0, 20.0}) {
    const BodyImage body = body_image(true, noise);
    const Bones bones = find_bones(body.volume, find_tube_axes(body.volume), {});
    ASSERT_TRUE(bones.are_there) << noise;
    EXPECT_NEAR(bones.level.lumen, kBloodOfTrunk, 0.05 * kBloodOfTrunk);
    EXPECT_NEAR(bones.level.tissue, kFlesh, 15.0);
    EXPECT_GT(part_in(body.is_bone, bones.mask), 0.9) << noise;
    EXPECT_LT(part_in(body.is_blood, bones.mask), 0.05) << noise;
  }
}

TEST(Bones, AreNotSeenWhereThereAreNone) {
  const BodyImage body = body_image(false, 10.0);
  EXPECT_FALSE(find_bones(body.volume, find_tube_axes(body.volume), {}).are_there);
}

TEST(Bones, AreKeptOutOfTheLumen) {
  const BodyImage body = body_image(true, 15.0);
  const Segmentation result = segment_vessels(body.volume, {});
  EXPECT_THAT(result.warnings, Contains(HasSubstr("bone")));
  double inside = 0.0;
  for_each_voxel(body.volume.geometry, [&](const Vec3& p, std::size_t v) {
    inside += body.is_bone.values[v] && interpolate(result.level_set, p) < 0.0;
  });
  double all = 0.0;
  for (const auto value : body.is_bone.values) all += value;
  EXPECT_LT(inside, 0.02 * all);
  // The wall that looks away from the bone, and the branch.
  for (double z = -20.0; z <= 20.0; z += 2.0) {
    EXPECT_LT(interpolate(result.level_set, {0.0, -(kAorta - 0.4), z}), 0.0) << z;
    EXPECT_GT(interpolate(result.level_set, {0.0, -(kAorta + 0.4), z}), 0.0) << z;
  }
  EXPECT_LT(interpolate(result.level_set, {-25.0, 0.0, 0.0}), 0.0);
}

/// Muscle in fat, an artery along z, and two veins with contrast in streaks; with an even, bright
/// rod (an implant), if asked for.
struct UnmixedBolus {
  static constexpr double kMixed = 200.0;
  Volume<float> volume;
  Volume<std::uint8_t> artery, bright;
  explicit UnmixedBolus(bool with_rod) {
    const VolumeGeometry grid = grid_of({90, 90, 70}, {1.0, 1.0, 1.0});
    volume = Volume<float>(grid);
    artery = bright = Volume<std::uint8_t>(grid);
    std::mt19937 random(7);
    std::vector<float> streaks(64 * 64 * 64);
    std::uniform_real_distribution<float> streak(600.0f, 1800.0f);
    for (float& value : streaks) value = streak(random);
    for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
      const bool is_vein = std::hypot(p.x - 26.0, p.y) < 6.0 || std::hypot(p.x, p.y - 26.0) < 4.0;
      const bool is_rod = with_rod && std::hypot(p.x + 27.0, p.y) < 6.0 && std::abs(p.z) < 25.0;
      artery.values[v] = std::hypot(p.x, p.y) < 15.0;
      bright.values[v] = is_vein || is_rod;
      const auto cell = [](double x) { return std::size_t(std::floor(x / 3.0) + 32.0); };
      volume.values[v] = artery.values[v] ? float(kMixed)
                         : is_vein        ? streaks[(cell(p.x) * 64 + cell(p.y)) * 64 + cell(p.z)]
                         : is_rod         ? 1500.0f
                                          : float(std::hypot(p.x, p.y) < 40.0 ? kFlesh : kFat);
    });
    volume = smooth(volume, 0.7);
    std::normal_distribution<float> noise(0.0f, 10.0f);
    for (float& value : volume.values) value += noise(random);
  }
};

TEST(Bones, VeinsWithAnUnmixedBolusAreNoLevelOfBlood) {
  for (const bool with_rod : {false, true}) {
    const UnmixedBolus body(with_rod);
    const Bones bones = find_bones(body.volume, find_tube_axes(body.volume), {});
    ASSERT_TRUE(bones.are_there);
    EXPECT_NEAR(bones.level.lumen, UnmixedBolus::kMixed, 0.05 * UnmixedBolus::kMixed) << with_rod;
    EXPECT_NEAR(bones.level.tissue, kFlesh, 15.0) << with_rod;
    EXPECT_GT(part_in(body.bright, bones.mask), 0.9) << with_rod;
    EXPECT_LT(part_in(body.artery, bones.mask), 0.02) << with_rod;
    EXPECT_THAT(bones.warning, HasSubstr("brighter than most of the blood"));
  }
}

TEST(Bones, KidneysBesideABrighterAortaAreNoBlood) {
  constexpr float kOpacified = 330.0f, kKidney = 190.0f;
  const VolumeGeometry grid = grid_of({90, 70, 90}, {1.0, 1.0, 1.0});
  Volume<float> volume(grid);
  Volume<std::uint8_t> aorta(grid);
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0f, 10.0f);
  for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
    aorta.values[v] = std::hypot(p.x, p.y) < 8.0;
    const bool is_kidney = std::hypot((std::abs(p.x) - 27.0) / 14.0, p.y / 18.0, p.z / 32.0) < 1.0;
    volume.values[v] = aorta.values[v] ? kOpacified
                       : is_kidney     ? kKidney
                                       : float(std::hypot(p.x, p.y) < 34.0 ? kFlesh : kFat);
  });
  volume = smooth(volume, 0.7);
  for (float& value : volume.values) value += noise(random);
  const Bones bones = find_bones(volume, find_tube_axes(volume), {});
  EXPECT_LT(part_in(aorta, bones.mask), 0.02);
  if (bones.are_there) {
    EXPECT_NEAR(bones.level.lumen, kOpacified, 20.0);
  }
}

TEST(Bones, MuscleAgainstAirIsNoPoolOfBlood) {
  const UnmixedBolus body(false);
  const BloodLevel level = find_bones(body.volume, find_tube_axes(body.volume), {}).level;
  ASSERT_TRUE(level.is_of_pools);
  EXPECT_FALSE(is_muscle(level, body.volume));
  // As MR shows a limb: muscle as bright as those pools fills half of the scan.
  Volume<float> limb = body.volume;
  for_each_voxel(limb.geometry, [&](const Vec3& p, std::size_t v) {
    if (std::hypot(p.x, p.y) < 36.0 && body.bright.values[v] == 0)
      limb.values[v] = float(UnmixedBolus::kMixed);
  });
  EXPECT_TRUE(is_muscle(level, limb));
  BloodLevel of_tubes = level;
  of_tubes.is_of_pools = false;
  EXPECT_FALSE(is_muscle(of_tubes, limb));
}

TEST(Couch, IsNoVessel) {
  const auto on_couch = [](double blood) {  // 18 cm of body over a rail
    BodyImage body = body_image(true, 10.0, blood, 3.0);
    std::mt19937 random(8);
    std::normal_distribution<float> rail(float(kBloodOfTrunk), 10.0f);
    for_each_voxel(body.volume.geometry, [&](const Vec3& p, std::size_t v) {
      if (p.y < -15.0 && std::hypot(p.x, p.y) > 38.0) body.volume.values[v] = -1000.0f;  // air
      if (std::hypot(p.x - 30.0, p.y + 36.0) < 5.0) body.volume.values[v] = rail(random);
    });
    return body.volume;
  };
  const auto in_rail = [](const Segmentation& result) {
    int count = 0;
    for_each_voxel(result.mask.geometry, [&](const Vec3& p, std::size_t v) {
      count += result.mask.values[v] != 0 && std::hypot(p.x - 30.0, p.y + 36.0) < 5.0;
    });
    return count;
  };
  const Segmentation with_contrast = segment_vessels(on_couch(kBloodOfTrunk), {});
  EXPECT_LT(interpolate(with_contrast.level_set, {0.0, 0.0, 0.0}), 0.0);
  EXPECT_EQ(in_rail(with_contrast), 0);
  try {
    EXPECT_EQ(in_rail(segment_vessels(on_couch(kFlesh), {})), 0);
  } catch (const InputError&) {  // without contrast it may find nothing
  }
}

TEST(EvenLevel, IsThatOfAHeartWhereNoTubeIsLongEnough) {
  constexpr double kPlace = 100.0;  // [mm^3]
  std::vector<float> even;
  std::mt19937 random(3);
  const auto add = [&](double mean, int count) {
    std::normal_distribution<float> values(float(mean), 5.0f);
    for (int n = 0; n < count; ++n) even.push_back(values(random));
  };
  add(kFat, 3000);
  add(kFlesh, 3000);
  add(130.0, 2000);  // a liver with contrast
  BloodLevel rough;
  rough.lumen = 400.0f;  // the bones have their say
  rough.tissue = float(kFlesh);
  const std::vector<float> without_heart = even;
  add(kBloodOfTrunk, 500);
  const BloodLevel level = find_even_level({}, even, kPlace, rough);
  EXPECT_TRUE(level.is_told && level.is_even && !level.is_of_pools);
  EXPECT_NEAR(level.lumen, kBloodOfTrunk, 5.0);
  EXPECT_NEAR(level.tissue, 130.0, 5.0);
  even = without_heart;
  add(kBloodOfTrunk, 100);  // 10 ml
  EXPECT_FALSE(find_even_level({}, even, kPlace, rough).is_told);
}

/// Noise of 15 at one end and of 30 at the other, as in a head and shoulders.
TEST(Evenness, IsMeasuredByTheNoiseAround) {
  const VolumeGeometry grid = grid_of({50, 50, 160}, {1.0, 1.0, 1.0});
  Volume<float> volume(grid);
  std::mt19937 random(9);
  std::normal_distribution<float> noise(0.0f, 1.0f);
  for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
    const bool is_blood = std::hypot(p.x, p.y) < kAorta;
    const bool is_cut = std::hypot(p.x - 17.0, p.y) < 7.0;  // at the scale's end
    volume.values[v] = is_cut ? 3071.0f
                              : float(is_blood ? kBloodOfTrunk : kFlesh) +
                                    (p.z < 40.0 ? 15.0f : 30.0f) * noise(random);
  });
  BloodLevel level;
  level.lumen = float(kBloodOfTrunk);
  level.tissue = float(kFlesh);
  const Evenness evenness = find_evenness(volume, level);
  const auto even_part = [&](double from_z, double to_z, double x) {
    double even = 0.0, all = 0.0;
    for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
      if (p.z < from_z || p.z > to_z || std::hypot(p.x - x, p.y) > 2.0) return;
      all += 1.0;
      even += evenness.is_even(v);
    });
    return even / all;
  };
  EXPECT_GT(even_part(-60.0, 0.0, 0.0), 0.9);
  EXPECT_GT(even_part(60.0, 75.0, 0.0), 0.9);
  EXPECT_LT(even_part(-60.0, 75.0, 17.0), 0.01);
}

/// A slab across the chest, 40 mm thick: a heart, and an aorta between lung and the spine.
TEST(Bones, TrunksAreSoughtAgainWithoutTheSpine) {
  const VolumeGeometry grid = grid_of({150, 130, 16}, {1.0, 1.0, 2.5});
  Volume<float> volume(grid);
  std::mt19937 random(5);
  std::vector<float> struts(64 * 64 * 64);
  std::uniform_real_distribution<float> strut(100.0f, 600.0f);
  for (float& value : struts) value = strut(random);
  const auto cell = [](double x) { return std::size_t(std::floor(x / 2.5) + 32.0); };
  for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
    const double to_aorta = std::hypot(p.x - 12.0, p.y - 10.0);
    const double to_heart = norm(p - Vec3{-12.0, -32.0, 0.0});
    const double in_spine = 18.0 - std::hypot(p.x, p.y - 35.0);
    volume.values[v] =
        float(to_aorta < 9.0 || to_heart < 25.0 ? kBloodOfTrunk
              : in_spine > 3.0 ? struts[(cell(p.x) * 64 + cell(p.y)) * 64 + cell(p.z)]
              : in_spine > 0.0 ? 900.0
              : p.y > 15.0 || std::abs(p.x) > 45.0 ? kFlesh
                                                   : -800.0);
  });
  volume = smooth(volume, 0.7);
  std::normal_distribution<float> noise(0.0f, 10.0f);
  for (float& value : volume.values) value += noise(random);
  const Bones bones = find_bones(volume, find_tube_axes(volume), {});
  ASSERT_TRUE(bones.are_there);
  double length = 0.0;
  for (const TubeAxis& axis : bones.trunks)
    for (const std::size_t v : axis.voxels) {
      const auto voxel = voxel_of(grid, v);
      const Vec3 p = grid.lps_from_index({double(voxel[0]), double(voxel[1]), double(voxel[2])});
      if (std::hypot(p.x - 12.0, p.y - 10.0) < 4.0) length += axis.length_share;
    }
  EXPECT_GT(length, 5.0);  // an axis counts with two fifths of its length
}

TEST(EvenLevel, IsThatOfVesselsDarkerThanBone) {
  std::vector<float> even;
  std::mt19937 random(3);
  std::normal_distribution<float> muscle(float(kFlesh), 5.0f);
  for (int n = 0; n < 5000; ++n) even.push_back(muscle(random));
  BloodLevel rough;  // of a skull
  rough.lumen = 900.0f;
  rough.tissue = float(kFlesh);
  const auto tube = [](double intensity, double length) {
    TubeAxis axis;
    axis.radius_mm = 3.0;
    axis.length_share = length / 10.0;
    axis.voxels.assign(10, 0);
    axis.contrast.assign(10, 100.0f);
    axis.intensity.assign(10, float(intensity));
    return axis;
  };
  const TubeAxis strand = tube(kFlesh, 100.0), carotid = tube(kBloodOfTrunk, 40.0);
  const BloodLevel level = find_even_level({strand, carotid}, even, 10.0, rough);
  EXPECT_TRUE(level.is_told && level.is_of_pools);
  EXPECT_NEAR(level.lumen, kBloodOfTrunk, 1.0);
  EXPECT_NEAR(level.tissue, kFlesh, 5.0);
  EXPECT_FALSE(find_even_level({strand, tube(kBloodOfTrunk, 5.0)}, even, 10.0, rough).is_told);
}

/// A leg: an artery along z and, 16 mm beside it, a bone with marrow of fat from end to end.
Volume<float> leg_image(double artery, const Vec3& axis, double bone, double cortex_hu) {
  TubeImage image;
  image.size = {90, 60, 90};
  image.spacing = {0.6, 0.6, 0.8};
  image.background = kFlesh;
  image.lumen = kBloodOfTrunk;
  image.blur_mm = 0.5;
  Volume<float> volume = image_of(image, [&](const Vec3& p) {
    return std::hypot(p.x - 9.07, p.y + 0.04) - artery - 0.2 * std::sin(0.2 * p.z);
  });
  std::mt19937 random(4);
  std::normal_distribution<float> noise(0.0f, 18.0f);
  for_each_voxel(volume.geometry, [&](const Vec3& p, std::size_t v) {
    const double out = std::hypot(p.x - axis.x, p.y - axis.y) - bone;
    const auto edge = [](double d) { return 0.5 * std::erfc(d / (std::sqrt(2.0) * 0.5)); };
    volume.values[v] +=
        float(edge(out) * (cortex_hu - kFlesh) - edge(out + 2.5) * (cortex_hu - kFat)) +
        noise(random);
  });
  return volume;
}

/// An artery of 4 mm is found beside it, and no voxel of the bone.
void expect_artery_alone(const Vec3& axis, double bone, double cortex_hu) {
  SCOPED_TRACE(testing::Message() << bone << " mm, " << cortex_hu << " HU");
  const Segmentation result = segment_vessels(leg_image(2.0, axis, bone, cortex_hu), {});
  double in_bone = 0.0;
  for_each_voxel(result.mask.geometry, [&](const Vec3& p, std::size_t v) {
    in_bone += result.mask.values[v] && std::hypot(p.x - axis.x, p.y - axis.y) < bone;
  });
  EXPECT_EQ(in_bone, 0.0);
  for (double z = -30.0; z <= 30.0; z += 5.0)
    EXPECT_LT(interpolate(result.level_set, {9.07, -0.04, z}), -1.0) << z;
}

TEST(Bones, ATubeOfBoneIsNoVessel) {
  expect_artery_alone({-10.0, 2.0, 0.0}, 4.5, 900.0);
  expect_artery_alone({-10.0, 2.0, 0.0}, 7.0, 1400.0);
  expect_artery_alone({-10.0, 2.0, 0.0}, 9.0, 900.0);
}

TEST(Bones, WideTubesOfBoneTellNoLevel) {
  const Volume<float> leg = leg_image(2.0, {-22.0, 12.0, 0.0}, 7.0, 1200.0);  // cut by the border
  const std::vector<TubeAxis> axes = find_tube_axes(leg);
  const auto is_of_bone = [](const TubeAxis& axis) {
    return axis.radius_mm > 3.0 && axis.intensity[axis.intensity.size() / 2] > 700.0f;
  };
  ASSERT_GT(std::count_if(axes.begin(), axes.end(), is_of_bone), 0);
  const std::vector<TubeAxis> tubes = find_bones(leg, axes, {}).tubes;
  EXPECT_EQ(std::count_if(tubes.begin(), tubes.end(), is_of_bone), 0);
  const auto dark = [](const std::vector<TubeAxis>& some) {
    return std::count_if(some.begin(), some.end(),
                         [](const TubeAxis& axis) { return axis.intensity.front() < 600.0f; });
  };
  EXPECT_EQ(dark(tubes), dark(axes));  // the artery's are all there
}

TEST(Bones, TubesDarkerThanTissueAreNotLeftAlone) {
  // An MR: quiet air around, and an aorta that is uneven by its flow. Folds of skin are tubes, too.
  Volume<float> volume(grid_of({80, 80, 50}, {1.0, 1.0, 2.0}));
  std::mt19937 random(6);
  std::normal_distribution<float> normal;
  const auto is_aorta = [](const Vec3& p) { return std::hypot(p.x, p.y) < 9.0; };
  const auto is_fold = [](const Vec3& p) { return std::hypot(p.x - 34.0, p.y) < 3.0; };
  for_each_voxel(volume.geometry, [&](const Vec3& p, std::size_t v) {
    volume.values[v] = is_aorta(p)                   ? 1600.0f + 60.0f * normal(random)
                       : std::hypot(p.x, p.y) < 25.0 ? 500.0f + 30.0f * normal(random)
                       : is_fold(p)                  ? 30.0f + normal(random)
                                                     : 5.0f + normal(random);
  });
  volume = smooth(volume, 0.7);
  const auto brightest = [](const std::vector<TubeAxis>& axes) {
    float most = 0.0f;
    for (const TubeAxis& axis : axes)
      for (const float value : axis.intensity) most = std::max(most, value);
    return most;
  };
  const std::vector<TubeAxis> axes = find_tube_axes(volume);
  ASSERT_GT(brightest(axes), 1400.0f);
  EXPECT_GT(brightest(find_bones(volume, axes, {}).tubes), 1400.0f);
  const Segmentation result = segment_vessels(volume, {});
  EXPECT_LT(interpolate(result.level_set, {0.0, 0.0, 0.0}), -5.0);
  EXPECT_GT(result.lumen_intensity, 1400.0);
}

/// A body with a ball beside the aorta, and which part of the ball is kept out.
double ball_kept_out(const std::function<double(const Vec3&)>& share_of_blood) {
  BodyImage body = body_image(true, 12.0);
  Volume<std::uint8_t> ball(body.volume.geometry);
  std::mt19937 random(9);
  std::normal_distribution<float> noise(0.0f, 12.0f);
  for_each_voxel(ball.geometry, [&](const Vec3& p, std::size_t v) {
    if (distance(p, {-24.0, -16.0, 0.0}) > 11.0) return;
    ball.values[v] = 1;
    body.volume.values[v] =
        float(kFlesh + share_of_blood(p) * (kBloodOfTrunk - kFlesh)) + noise(random);
  });
  const Bones bones = find_bones(body.volume, find_tube_axes(body.volume), {});
  EXPECT_TRUE(bones.are_there);
  EXPECT_LT(part_in(body.is_blood, bones.mask), 0.05);
  return bones.are_there ? part_in(ball, bones.mask) : 0.0;
}

TEST(Bones, AnOrganIsDarkerThanBloodAndUneven) {
  const auto streaks = [](double mean) {
    return [mean](const Vec3& p) { return mean + 0.12 * std::sin(p.x / 1.2); };
  };
  EXPECT_GT(ball_kept_out(streaks(0.64)), 0.9);  // cortex and medulla
  EXPECT_LT(ball_kept_out(streaks(0.85)), 0.1);  // a heart whose contrast is not mixed
  EXPECT_LT(ball_kept_out([](const Vec3&) { return 0.72; }), 0.1);  // less contrast, but even
  EXPECT_GT(ball_kept_out([](const Vec3&) { return 0.6; }), 0.9);   // far less: a vein or a spleen
}

TEST(Bones, ASeedMakesABodyAVessel) {
  const BodyImage body = body_image(true, 15.0);
  SegmentationOptions options;
  options.seeds_lps_mm = {{0.0, kAorta + 14.0, 0.0}};
  const Bones bones = find_bones(body.volume, find_tube_axes(body.volume), options);
  const bool is_kept = !bones.are_there || part_in(body.is_bone, bones.mask) < 0.5;
  EXPECT_TRUE(is_kept);
}

}  // namespace
}  // namespace angio::segmentation
