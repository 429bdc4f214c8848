#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/error.hpp"
#include "segmentation/detail/wide_parts.hpp"
#include "tests/segmentation/grids.hpp"

namespace angio::segmentation {
namespace {

constexpr double kChamber = 9.0, kVessel = 1.5, kSpacing = 0.5;  // radii, voxels [mm]

using Shape = std::function<double(const Vec3&)>;

double chamber(const Vec3& p) { return norm(p) - kChamber; }

/// Two vessels out of the chamber, along x and against it, through the voxels' centres.
double vessel(const Vec3& p, double side) {
  const double axis = std::hypot(p.y - 0.25, p.z + 0.25);
  return side * p.x > 0.0 ? axis - kVessel : norm(p) - kVessel;
}

double heart(const Vec3& p) { return std::min({chamber(p), vessel(p, 1.0), vessel(p, -1.0)}); }

Segmentation lumen_of(const Shape& shape) {
  Segmentation lumen;
  lumen.level_set =
      Volume<float>(test::grid_of({90, 44, 44}, {kSpacing, kSpacing, kSpacing}), 0.0f);
  test::for_each_voxel(lumen.level_set.geometry, [&](const Vec3& p, std::size_t v) {
    lumen.level_set.values[v] = float(shape(p));
  });
  return lumen;
}

SegmentationOptions narrower_than(double diameter) {
  SegmentationOptions options;
  options.max_diameter_mm = diameter;
  return options;
}

/// The first and the last x that is inside [mm].
std::pair<double, double> extent_of(const Segmentation& lumen) {
  std::pair<double, double> extent{1e9, -1e9};
  test::for_each_voxel(lumen.mask.geometry, [&](const Vec3& p, std::size_t v) {
    if (!lumen.mask.values[v]) return;
    extent = {std::min(extent.first, p.x), std::max(extent.second, p.x)};
  });
  return extent;
}

TEST(WideParts, LeaveAVesselFromAQuarterOfTheBallBeyondItsChamber) {
  Segmentation lumen = lumen_of(heart);
  SegmentationOptions options = narrower_than(6.0);
  options.seeds_lps_mm = {{20.0, 0.0, 0.0}};
  detail::leave_out_wide_parts(options, lumen);
  const auto [first, last] = extent_of(lumen);
  // The face is a sphere's: it begins beside the axis.
  const double face = std::sqrt(std::pow(kChamber + 0.25 * 3.0, 2) - kVessel * kVessel);
  EXPECT_GT(first, face);
  EXPECT_LT(first, face + 1.5 * kSpacing);  // the closed corner beside the mouth adds a little
  EXPECT_NEAR(last, 22.25, 0.01);           // the grid's end
  // The vessel itself is as it was: its deepest place has its radius.
  const auto& d = lumen.level_set.values;
  EXPECT_NEAR(-*std::min_element(d.begin(), d.end()), kVessel, 0.1 * kSpacing);
  // So are its voxels.
  test::for_each_voxel(lumen.mask.geometry, [&](const Vec3& p, std::size_t v) {
    if (p.x > first + kSpacing) {
      EXPECT_EQ(lumen.mask.values[v] != 0, vessel(p, 1.0) < 0.0) << v;
    }
  });
}

TEST(WideParts, SeedsChooseAndTheOthersAreTold) {
  Segmentation one = lumen_of(heart), both = lumen_of(heart);
  SegmentationOptions options = narrower_than(6.0);
  options.seeds_lps_mm = {{-20.0, 0.0, 0.0}};
  detail::leave_out_wide_parts(options, one);
  EXPECT_LT(extent_of(one).second, 0.0);
  ASSERT_EQ(one.warnings.size(), 3u);
  EXPECT_NE(one.warnings[0].find("wider than 6 mm"), std::string::npos) << one.warnings[0];
  EXPECT_NE(one.warnings[1].find("1 other piece"), std::string::npos) << one.warnings[1];
  EXPECT_NE(one.warnings[2].find("opens into what was left out at [-"), std::string::npos)
      << one.warnings[2];
  options.seeds_lps_mm.push_back({20.0, 0.0, 0.0});
  detail::leave_out_wide_parts(options, both);
  EXPECT_LT(extent_of(both).first, 0.0);
  EXPECT_GT(extent_of(both).second, 0.0);
  ASSERT_EQ(both.warnings.size(), 2u);
  EXPECT_NE(both.warnings[1].find("], ["), std::string::npos) << "two mouths";
  options.seeds_lps_mm = {{0.0, 0.0, 0.0}};  // in the chamber
  Segmentation none = lumen_of(heart);
  EXPECT_THROW(detail::leave_out_wide_parts(options, none), InputError);
}

/// The chamber's inside is cut by gaps of 1 mm, every 3 mm: no ball of 3 mm fits in anywhere.
TEST(WideParts, AChamberThatMusclesDivideIsOne) {
  const auto divided = [](const Vec3& p) {
    const double x = p.x - 1.5 - 3.0 * std::round((p.x - 1.5) / 3.0);
    return std::min(std::max(chamber(p), 0.5 - std::abs(x)),
                    std::max(vessel(p, 1.0), kChamber - 0.2 - p.x));
  };
  Segmentation lumen = lumen_of(divided);
  SegmentationOptions options = narrower_than(6.0);
  options.seeds_lps_mm = {{20.0, 0.0, 0.0}};
  detail::leave_out_wide_parts(options, lumen);
  // Of the slab that the vessel hangs on, half a ball's radius around it is given back.
  test::for_each_voxel(lumen.mask.geometry, [&](const Vec3& p, std::size_t v) {
    if (lumen.mask.values[v] != 0 && p.x < kChamber) {
      EXPECT_LT(std::hypot(p.y, p.z), kVessel + 1.5 + kSpacing);
    }
  });
  EXPECT_GT(extent_of(lumen).first, kChamber - 1.5);
}

/// Beside a chamber, nearer than the gaps that are closed, a vessel keeps its side.
TEST(WideParts, AVesselBesideAChamberIsWhole) {
  constexpr double kGap = 0.8, kBall = 6.0;
  const auto beside = [](const Vec3& p) {
    return std::hypot(p.y - kBall - kGap - kVessel, p.z) - kVessel;
  };
  Segmentation lumen =
      lumen_of([&](const Vec3& p) { return std::min(norm(p) - kBall, beside(p)); });
  SegmentationOptions options = narrower_than(6.0);
  options.seeds_lps_mm = {{20.0, kBall + kGap + kVessel, 0.0}};
  detail::leave_out_wide_parts(options, lumen);
  std::size_t inside = 0, wrong = 0;
  test::for_each_voxel(lumen.mask.geometry, [&](const Vec3& p, std::size_t v) {
    inside += beside(p) < 0.0;
    wrong += (lumen.mask.values[v] != 0) != (beside(p) < 0.0);
  });
  EXPECT_GT(inside, 2000u);
  EXPECT_EQ(wrong, 0u);
}

TEST(WideParts, NothingIsTakenFromNarrowVesselsOrUnasked) {
  const auto tube = [](const Vec3& p) { return vessel(p, 1.0); };
  for (const double most : {0.0, 6.0}) {
    Segmentation lumen = lumen_of(tube);
    const double before =
        *std::min_element(lumen.level_set.values.begin(), lumen.level_set.values.end());
    detail::leave_out_wide_parts(narrower_than(most), lumen);
    EXPECT_NEAR(*std::min_element(lumen.level_set.values.begin(), lumen.level_set.values.end()),
                before, 0.1 * kSpacing);
    EXPECT_TRUE(lumen.warnings.empty());
  }
}

TEST(WideParts, RefuseALumenWithoutNarrowVessels) {
  Segmentation lumen = lumen_of(chamber);
  EXPECT_THROW(detail::leave_out_wide_parts(narrower_than(6.0), lumen), InputError);
}

}  // namespace
}  // namespace angio::segmentation
