#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "meshing/detail/wire_beyond.hpp"

/// The guidewire beyond the balloon.
namespace angio::meshing {
namespace {

constexpr double kBend = 20.0, kVesselRadius = 1.5, kSmoothing = 0.75;
constexpr double kLeft = 18.0, kBalloon = 10.0, kPathLength = 34.0;  // 6 mm are left at the end

/// A quarter of a circle and more around the origin, in the plane of x and y.
Vec3 on_circle(double abscissa, double radius = kBend) {
  return {radius * std::cos(abscissa / kBend), radius * std::sin(abscissa / kBend), 0.0};
}

CenterlinePath arc_path() {
  CenterlinePath path;
  for (int i = 0; i <= 340; ++i) {
    path.points.push_back(on_circle(0.1 * i));
    path.abscissa.push_back(0.1 * i);
    path.inscribed_radius.push_back(kVesselRadius);
    path.section_area.push_back(units::kPi * kVesselRadius * kVesselRadius);
    path.equivalent_radius.push_back(kVesselRadius);
  }
  return path;
}

/// A balloon whose wire is a chord across the bend: off the line and askew to it at both poles.
Balloon across_the_bend() {
  Balloon balloon;
  const Vec3 first = on_circle(kLeft, kBend + 0.3), last = on_circle(kLeft + kBalloon, kBend + 0.3);
  for (int i = 0; i < 21; ++i) balloon.guidewire.push_back(first + i / 20.0 * (last - first));
  detail::extend_wire(arc_path(), kSmoothing, balloon);
  return balloon;
}

std::vector<Vec3> whole(const Balloon& balloon) {
  std::vector<Vec3> wire = balloon.guidewire_before;
  for (const auto* part : {&balloon.guidewire, &balloon.guidewire_behind})
    wire.insert(wire.end(), part->begin(), part->end());
  return wire;
}

TEST(WireBeyond, ReachesTenMillimetresOrTheEndOfTheLine) {
  const Balloon balloon = across_the_bend();
  const double spacing = distance(balloon.guidewire[0], balloon.guidewire[1]);
  EXPECT_NEAR(spacing * double(balloon.guidewire_before.size()), detail::kWireBeyond, spacing);
  EXPECT_NEAR(spacing * double(balloon.guidewire_behind.size()), kPathLength - kLeft - kBalloon,
              spacing);
  EXPECT_LT(distance(balloon.guidewire_before.front(), on_circle(kLeft - detail::kWireBeyond)),
            1.5 * spacing);
}

TEST(WireBeyond, LeavesThePolesInTheWiresDirection) {
  const Balloon balloon = across_the_bend();
  const std::vector<Vec3> wire = whole(balloon);
  const double spacing = distance(balloon.guidewire[0], balloon.guidewire[1]);
  // Onto a line 0.3 mm off and askew by 0.25 it comes over one diameter: curvature is at most 4
  // (askew) / w + 6 (off) / w^2 + 1 / bend.
  const double diameter = 2.0 * kVesselRadius;
  const double most =
      spacing * (4.0 * 0.27 / diameter + 6.0 * 0.3 / (diameter * diameter) + 1.0 / kBend);
  for (std::size_t i = 1; i + 1 < wire.size(); ++i) {
    const Vec3 a = wire[i] - wire[i - 1], b = wire[i + 1] - wire[i];
    EXPECT_LT(std::atan2(norm(cross(a, b)), dot(a, b)), most) << i;
    EXPECT_GT(norm(b), 0.5 * spacing) << i;
  }
}

TEST(WireBeyond, RunsAlongTheVessel) {
  const Balloon balloon = across_the_bend();
  for (const auto* part : {&balloon.guidewire_before, &balloon.guidewire_behind})
    for (const Vec3& p : *part) EXPECT_NEAR(norm(p), kBend, 0.4) << p.x << ' ' << p.y;
  for (std::size_t i = 0; i < 10; ++i)  // further away than a diameter; smoothing cuts the bend
    EXPECT_NEAR(norm(balloon.guidewire_before[i]), kBend,
                0.02 + 0.5 * kSmoothing * kSmoothing / kBend);
}

TEST(WireBeyond, OfAWireOfOneNodeIsNothing) {
  Balloon balloon;
  balloon.guidewire = {on_circle(kLeft)};
  detail::extend_wire(arc_path(), kSmoothing, balloon);
  EXPECT_TRUE(balloon.guidewire_before.empty());
  EXPECT_TRUE(balloon.guidewire_behind.empty());
}

}  // namespace
}  // namespace angio::meshing
