#include <gtest/gtest.h>

#include <cstdio>

#include "centerline/centerline.hpp"
#include "testing/centerline/shapes.hpp"

/// What is measured from surfaces whose true middle line and radius are known; each test prints it.
namespace angio::centerline {
namespace {

using test::make_tube;
using test::surface_of;
using test::Tube;

constexpr double kRadius = 1.5, kThroat = 0.6, kLength = 40.0;

Tube straight() {
  return make_tube(
      [](double t) {
        return Vec3{0.1 * kLength * t, 0.2 * kLength * t, kLength * t};
      },
      [](double) { return kRadius; }, 15001);
}

Tube helix() {
  return make_tube(
      [](double t) {
        const double a = 3.0 * units::kPi * t;
        return Vec3{10.0 * std::cos(a), 10.0 * std::sin(a), 30.0 * t};
      },
      [](double) { return kRadius; }, 15001);
}

/// 60 % narrower in its middle, over 9 mm.
Tube stenosed() {
  return make_tube(
      [](double t) {
        return Vec3{0, 0, kLength * t};
      },
      [](double t) {
        const double x = kLength * (t - 0.5) / 4.5;
        const double dip = std::abs(x) < 1.0 ? 0.5 * (1.0 + std::cos(units::kPi * x)) : 0.0;
        return kRadius - (kRadius - kThroat) * dip;
      },
      15001);
}

TriangleMesh with_noise(TriangleMesh mesh, double sd_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, sd_mm);
  if (sd_mm > 0.0)
    for (Vec3& p : mesh.vertices) p += Vec3{normal(random), normal(random), normal(random)};
  return mesh;
}

struct Measured {
  double position = 0.0;    // mean distance to the true line
  double inscribed = 0.0;   // mean error
  double equivalent = 0.0;  // mean error
  double throat = 0.0;      // least inscribed radius
};

/// Two diameters away from the caps.
Measured measure(const char* name, const Tube& tube, const TriangleMesh& mesh) {
  const CenterlineResult result = extract_centerline(mesh, {});
  EXPECT_EQ(result.tree.paths.size(), 1U);
  EXPECT_TRUE(test::without_inlet(result.warnings).empty());
  const CenterlinePath& path = result.tree.paths[0];
  Measured m;
  m.throat = 1e300;
  int count = 0;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const double end = std::min(path.abscissa[i], path.abscissa.back() - path.abscissa[i]);
    if (end < 4.0 * kRadius) continue;
    const auto truth = test::nearest_on(tube, path.points[i]);
    m.position += truth.distance;
    m.inscribed += measured_radius(path)[i] - truth.radius;
    m.equivalent += path.equivalent_radius[i] - truth.radius;
    m.throat = std::min(m.throat, measured_radius(path)[i]);
    ++count;
  }
  m.position /= count;
  m.inscribed /= count;
  m.equivalent /= count;
  std::printf(
      "%-22s %zu triangles: position %.5f mm, radius %+.5f mm, equivalent %+.5f mm, "
      "least radius %.4f mm\n",
      name, mesh.triangles.size(), m.position, m.inscribed, m.equivalent, m.throat);
  return m;
}

TEST(Accuracy, OfAnExactSurfaceIsAMicrometre) {
  for (const Tube& tube : {straight(), helix()}) {
    const Measured m = measure("exact", tube, surface_of(tube, 151, 100));
    EXPECT_LT(m.position, 1e-3);
    EXPECT_LT(std::abs(m.inscribed), 5e-4 * kRadius);
    EXPECT_LT(std::abs(m.equivalent), 5e-4 * kRadius);
  }
  const Measured m = measure("exact, 60 % stenosis", stenosed(), surface_of(stenosed(), 151, 100));
  EXPECT_LT(m.position, 1e-3);
  EXPECT_NEAR(m.throat, kThroat, 0.005 * kThroat);
}

TEST(Accuracy, IsNotEatenByNoiseOfTheVertices) {
  struct Bar {
    double noise, position, radius, throat;
  };
  for (const Bar& bar : {Bar{0.05, 0.02, 0.01, 0.015}, Bar{0.1, 0.03, 0.02, 0.03}}) {
    for (const Tube& tube : {straight(), helix()}) {
      const Measured m =
          measure("noisy", tube, with_noise(surface_of(tube, 151, 100), bar.noise, 1));
      EXPECT_LT(m.position, bar.position);
      EXPECT_LT(std::abs(m.inscribed), bar.radius);
      EXPECT_LT(std::abs(m.equivalent), bar.radius);
    }
    const Measured m = measure("noisy, 60 % stenosis", stenosed(),
                               with_noise(surface_of(stenosed(), 151, 100), bar.noise, 2));
    EXPECT_NEAR(m.throat, kThroat, bar.throat * kThroat);
  }
}

TEST(Accuracy, IsNotEatenByNoiseOfAFifthOfTheRadius) {
  // What looks like a second wall behind the first one is still the outer half of the noise.
  const double radius = 0.5;
  const Tube thin = make_tube(
      [](double t) {
        return Vec3{0, 0, 20.0 * t};
      },
      [&](double) { return radius; }, 15001);
  const Measured m = measure("thin, noisy", thin, with_noise(surface_of(thin, 151, 50), 0.1, 3));
  EXPECT_LT(std::abs(m.equivalent), 0.02 * radius);
  EXPECT_LT(std::abs(m.inscribed), 0.02 * radius);
  EXPECT_NEAR(m.throat, radius, 0.05 * radius);
}

TEST(Accuracy, HoldsWithFewVertices) {
  // 2,500 vertices.
  const Measured m = measure("few", helix(), surface_of(helix(), 101, 25));
  EXPECT_LT(m.position, 2e-3);
  EXPECT_LT(std::abs(m.inscribed), 2e-3);
}

TEST(Accuracy, InAFlatThroatTheLineStaysInTheMiddle) {
  // A stadium: 2.4 mm of straight sides between half circles of 0.6 mm in the middle, a circle of
  // 1.5 mm at the ends; the line must not wander along the flat.
  TriangleMesh mesh = surface_of(stenosed(), 151, 100);
  for (Vec3& p : mesh.vertices) {
    const double x = (p.z - 0.5 * kLength) / 4.5;
    const double dip = std::abs(x) < 1.0 ? 0.5 * (1.0 + std::cos(units::kPi * x)) : 0.0;
    const double radius = kRadius - (kRadius - kThroat) * dip, r = std::hypot(p.x, p.y);
    if (r > 0.0) p.x += (kRadius - radius) * p.x / std::max(std::abs(p.x), 0.3 * r);
  }
  for (const double noise : {0.0, 0.03}) {
    const auto result = extract_centerline(with_noise(mesh, noise, 3), {});
    ASSERT_EQ(result.tree.paths.size(), 1U);
    double sum = 0.0;
    for (const Vec3& p : result.tree.paths[0].points) sum += std::hypot(p.x, p.y);
    EXPECT_LT(sum / double(result.tree.paths[0].points.size()), 0.03 + noise);
  }
}

}  // namespace
}  // namespace angio::centerline
