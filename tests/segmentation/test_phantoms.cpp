#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "datasets/phantom.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation {
namespace {

constexpr double kEnd = 4.0;  ///< [mm] of each branch's end that is left out

struct Case {
  const char* name;
  double spacing;
  double noise;
};

/// How far a segmentation is from the truth.
struct Accuracy {
  double volume_percent = 0.0;         ///< signed
  double surface_bias_mm = 0.0;        ///< positive: the lumen came out too small
  double surface_mm = 0.0;             ///< mean distance
  double radius_percent = 0.0;         ///< mean error of the radius from 24 rays
  double throat_diameter_error = 0.0;  ///< of the narrowest equivalent diameter at the lesion [mm]
  double centre_inside = 0.0;          ///< share of the true centreline that lies inside
};

double ray_length(const Volume<float>& level_set, const Vec3& from, const Vec3& along) {
  double before = interpolate(level_set, from);
  if (before >= 0.0) return 0.0;
  for (double r = 0.05; r < 15.0; r += 0.05) {
    const double here = interpolate(level_set, from + r * along);
    if (here >= 0.0) return r - 0.05 * here / (here - before);
    before = here;
  }
  return 15.0;
}

double equivalent_radius(const Volume<float>& level_set, const CenterlineSample& at) {
  const Vec3 u = any_perpendicular(at.tangent);
  const Vec3 v = cross(at.tangent, u);
  double squares = 0.0;
  for (int ray = 0; ray < 24; ++ray) {
    const double angle = ray * 3.14159265358979323846 / 12.0;
    const double length =
        ray_length(level_set, at.point, std::cos(angle) * u + std::sin(angle) * v);
    squares += length * length;
  }
  return std::sqrt(squares / 24.0);
}

bool near_an_end(const datasets::PhantomTruth& truth, const Vec3& point) {
  for (const auto& path : truth.tree.paths)
    if (distance(point, path.points.front()) < kEnd || distance(point, path.points.back()) < kEnd)
      return true;
  return false;
}

void measure_surface(const datasets::Phantom& phantom, const Volume<float>& level_set,
                     Accuracy& accuracy) {
  const auto areas = vertex_areas(phantom.surface);
  double total = 0.0;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    const Vec3& point = phantom.surface.vertices[v];
    if (near_an_end(phantom.truth, point)) continue;
    const double d = interpolate(level_set, point);
    accuracy.surface_bias_mm += areas[v] * d;
    accuracy.surface_mm += areas[v] * std::abs(d);
    total += areas[v];
  }
  accuracy.surface_bias_mm /= total;
  accuracy.surface_mm /= total;
}

void measure_radii(const datasets::Phantom& phantom, const Volume<float>& level_set,
                   Accuracy& accuracy) {
  double error = 0.0, inside = 0.0, count = 0.0;
  double throat = 1e9, true_throat = 1e9;
  for (std::size_t p = 0; p < phantom.truth.tree.paths.size(); ++p) {
    const auto& path = phantom.truth.tree.paths[p];
    for (double s = kEnd; s < path.abscissa.back() - kEnd; s += 0.4) {
      const auto at = sample(path, s);
      const double radius = equivalent_radius(level_set, at);
      error += std::abs(radius / at.equivalent_radius - 1.0);
      inside += interpolate(level_set, at.point) < 0.0 ? 1.0 : 0.0;
      count += 1.0;
      if (int(p) != phantom.truth.lesion_path ||
          std::abs(s - phantom.truth.lesion_abscissa_mm) > 3.0)
        continue;
      throat = std::min(throat, radius);
      true_throat = std::min(true_throat, at.equivalent_radius);
    }
  }
  accuracy.radius_percent = 100.0 * error / count;
  accuracy.centre_inside = inside / count;
  accuracy.throat_diameter_error = 2.0 * (throat - true_throat);
}

Accuracy measure(const datasets::Phantom& phantom, const Segmentation& result) {
  Accuracy accuracy;
  const Vec3 h = result.level_set.geometry.spacing;
  const double edge = std::cbrt(h.x * h.y * h.z);
  double volume = 0.0;
  for (float d : result.level_set.values)
    volume += std::clamp(0.5 - double(d) / edge, 0.0, 1.0) * h.x * h.y * h.z;
  accuracy.volume_percent = 100.0 * (volume / enclosed_volume(phantom.surface) - 1.0);
  measure_surface(phantom, result.level_set, accuracy);
  measure_radii(phantom, result.level_set, accuracy);
  return accuracy;
}

class SegmentPhantom : public testing::TestWithParam<Case> {};

TEST_P(SegmentPhantom, IsWithinTheBar) {
  datasets::PhantomOptions options;
  options.name = GetParam().name;
  options.spacing_mm = GetParam().spacing;
  options.noise_sd = GetParam().noise;
  const auto phantom = datasets::make_phantom(options);
  const auto result = segment_vessels(phantom.volume, {});
  const Accuracy a = measure(phantom, result);
  std::printf("| %s | %.2f | %.0f | %+.2f | %+.3f | %.3f | %.2f | %+.3f |\n", GetParam().name,
              GetParam().spacing, 100.0 * GetParam().noise, a.volume_percent, a.surface_bias_mm,
              a.surface_mm, a.radius_percent, a.throat_diameter_error);
  // Mean distances of a twelfth of a voxel at 10 % noise, more where noise is higher.
  const double part_of_voxel = GetParam().noise > 0.1 ? 0.12 : 0.08;
  EXPECT_LT(a.surface_mm, part_of_voxel * GetParam().spacing);
  EXPECT_LT(std::abs(a.surface_bias_mm), 0.02 * GetParam().spacing);
  EXPECT_LT(std::abs(a.volume_percent), 1.0);
  EXPECT_LT(a.radius_percent, 1.5);
  // Bias and two standard deviations of the throat's 1.2 mm.
  EXPECT_LT(std::abs(a.throat_diameter_error), 0.105 * 1.2);
  EXPECT_EQ(a.centre_inside, 1.0);
  EXPECT_EQ(detail::label_components(result.mask, detail::Connectivity::faces).count(), 1);
}

TEST(SegmentNarrowPhantom, AThroatBelowAVoxelStaysOpenAndIsTold) {
  datasets::PhantomOptions options;
  options.name = "unilateral";
  options.stenosis_percent = 90.0;  // 0.3 mm of 3 mm, on voxels of 0.3 mm
  const auto phantom = datasets::make_phantom(options);
  const auto result = segment_vessels(phantom.volume, {});
  EXPECT_EQ(detail::label_components(result.mask, detail::Connectivity::faces).count(), 1);
  const auto& path = phantom.truth.tree.paths.front();
  EXPECT_LT(interpolate(result.level_set, sample(path, kEnd).point), -1.0);
  EXPECT_LT(interpolate(result.level_set, sample(path, path.abscissa.back() - kEnd).point), -1.0);
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_NE(result.warnings[0].find("narrower than the voxels can show"), std::string::npos);
  ASSERT_EQ(result.narrow_lps_mm.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(Bar, SegmentPhantom,
                         testing::Values(Case{"straight", 0.3, 0.1}, Case{"unilateral", 0.3, 0.1},
                                         Case{"bilateral", 0.3, 0.1}, Case{"ytype", 0.3, 0.1},
                                         Case{"ytype", 0.4, 0.2}, Case{"unilateral", 0.2, 0.0}),
                         [](const auto& parameter) {
                           return std::string(parameter.param.name) + "_" +
                                  std::to_string(int(100 * parameter.param.spacing)) + "_noise" +
                                  std::to_string(int(100 * parameter.param.noise));
                         });

}  // namespace
}  // namespace angio::segmentation
