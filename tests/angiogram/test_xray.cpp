#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "angiogram/xray.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "testing/shapes.hpp"

namespace angio::angiogram {
namespace {

/// About z, its middle at the origin.
TriangleMesh closed_tube(double radius, double length, int around = 360) {
  TriangleMesh tube = tests::make_tube(radius, length, 3, around);
  for (Vec3& vertex : tube.vertices) vertex.z -= 0.5 * length;
  return with_caps(std::move(tube));
}

TriangleMesh ball(double radius) { return tests::make_sphere({}, radius, 7); }

TriangleMesh moved(TriangleMesh mesh, const Vec3& by) {
  for (Vec3& vertex : mesh.vertices) vertex += by;
  return mesh;
}

TriangleMesh inside_out(TriangleMesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

TriangleMesh both(TriangleMesh a, const TriangleMesh& b) {
  const int first = int(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Triangle& t : b.triangles)
    a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return a;
}

/// The picture's value at a place, right and up of its middle [mm].
double at(const std::vector<double>& picture, const XrayFrame& frame, double x, double y) {
  const auto pixel = [&](double mm) {
    return int(std::lround((mm + frame.half_size_mm) / frame.pixel_mm() - 0.5));
  };
  const int row = frame.pixels - 1 - pixel(y);
  return picture[std::size_t(row * frame.pixels + pixel(x))];
}

const XrayFrame kFront{{}, {}, 10.05, 201};  // rays 0.1 mm apart, one through the middle

TEST(ChordLengths, OfABallAreTwiceTheRootOfWhatIsLeftOfItsRadius) {
  for (const CArmAngles angles : {CArmAngles{0, 0}, CArmAngles{33, 21}, CArmAngles{0, 90}}) {
    XrayFrame frame = kFront;
    frame.angles = angles;
    const auto chords = chord_lengths(ball(6.0), frame);
    for (const double x : {-5.0, -2.0, 0.0, 3.0})
      for (const double y : {-2.0, 0.0, 3.0})
        EXPECT_NEAR(at(chords, frame, x, y), 2.0 * std::sqrt(36.0 - x * x - y * y), 0.02);
    EXPECT_EQ(at(chords, frame, 6.5, 0.0), 0.0);
    EXPECT_EQ(at(chords, frame, 5.0, 5.0), 0.0);
  }
}

TEST(ChordLengths, OfATubeFollowItsAngleToTheBeam) {
  const TriangleMesh tube = closed_tube(1.5, 30.0);
  for (const double secondary : {0.0, 30.0, 60.0}) {
    XrayFrame frame = kFront;
    frame.angles = {20.0, secondary};
    const auto chords = chord_lengths(tube, frame);
    for (const double x : {-1.0, 0.0, 0.8})
      EXPECT_NEAR(at(chords, frame, x, 0.0),
                  2.0 * std::sqrt(2.25 - x * x) / std::cos(secondary * units::kPi / 180.0), 0.01);
  }
  XrayFrame along = kFront;
  along.angles = {0, 90};
  EXPECT_NEAR(at(chord_lengths(tube, along), along, 0.5, 0.5), 30.0, 1e-9);
}

TEST(ChordLengths, AddUpToTheVolume) {
  const TriangleMesh mesh = moved(ball(4.0), {0.123, 0.0, 0.456});
  XrayFrame frame = kFront;
  frame.angles = {-41, 17};
  const auto chords = chord_lengths(mesh, frame);
  const double area = frame.pixel_mm() * frame.pixel_mm();
  EXPECT_NEAR(area * std::accumulate(chords.begin(), chords.end(), 0.0), enclosed_volume(mesh),
              2e-3 * enclosed_volume(mesh));
}

TEST(ChordLengths, OfVesselsBehindEachOtherAddUpAndHollowsAreLeftOut) {
  const TriangleMesh near = moved(ball(3.0), {0, -5, 0}), far = moved(ball(2.0), {0, 5, 0});
  EXPECT_NEAR(at(chord_lengths(both(near, far), kFront), kFront, 0.0, 0.0), 10.0, 0.02);
  const TriangleMesh shell = both(ball(6.0), inside_out(ball(4.0)));
  EXPECT_NEAR(at(chord_lengths(shell, kFront), kFront, 0.0, 0.0), 4.0, 0.02);
}

TEST(ChordLengths, NoRayIsLostOrCountedTwiceAtEdgesAndCorners) {
  // Every edge and corner of this tube, and the tips of its caps, lie on rays.
  TriangleMesh box = closed_tube(8.0, 16.0, 4);
  for (const CArmAngles angles : {CArmAngles{0, 0}, CArmAngles{0, 90}, CArmAngles{90, 0}}) {
    XrayFrame frame = kFront;
    frame.angles = angles;
    frame.half_size_mm = 10.5;
    frame.pixels = 21;
    for (const double chord : chord_lengths(box, frame)) {
      EXPECT_GE(chord, 0.0);
      EXPECT_LE(chord, 16.0 + 1e-9);
    }
    EXPECT_NEAR(at(chord_lengths(box, frame), frame, 0.0, 0.0), 16.0, 1e-9);
  }
}

TEST(ChordLengths, ThePictureIsSeenFromTheDetectorTheHeadUp) {
  const TriangleMesh mesh = moved(ball(1.0), {5, 3, 7});  // left, back, head
  EXPECT_NEAR(at(chord_lengths(mesh, kFront), kFront, 5.0, 7.0), 2.0, 0.02);
  XrayFrame left = kFront;
  left.angles = {90, 0};
  EXPECT_NEAR(at(chord_lengths(mesh, left), left, 3.0, 7.0), 2.0, 0.02);
  XrayFrame centred = kFront;
  centred.center = {5, 3, 7};
  EXPECT_NEAR(at(chord_lengths(mesh, centred), centred, 0.0, 0.0), 2.0, 0.02);
}

TEST(ChordLengths, OfAFrameThatIsNoneAreRefused) {
  EXPECT_THROW(chord_lengths(ball(1.0), XrayFrame{{}, {}, 0.0, 10}), InputError);
  EXPECT_THROW(chord_lengths(ball(1.0), XrayFrame{{}, {}, 1.0, 0}), InputError);
  EXPECT_THROW(chord_lengths(ball(1.0), XrayFrame{{}, {}, std::nan(""), 10}), InputError);
}

TEST(Transmissions, FallByHalfWithEachHalfValueLayer) {
  const double half_value = std::log(2.0) / kContrastMedium;
  const auto left = transmissions({0.0, half_value, 3.0 * half_value}, kContrastMedium);
  EXPECT_DOUBLE_EQ(left[0], 1.0);
  EXPECT_NEAR(left[1], 0.5, 1e-12);
  EXPECT_NEAR(left[2], 0.125, 1e-12);
}

TEST(WithCaps, ATubeIsClosedAndItsNormalsPointOutward) {
  const TriangleMesh tube = closed_tube(2.0, 10.0);
  EXPECT_TRUE(surface_topology(tube).is_closed());
  EXPECT_NEAR(enclosed_volume(tube), 40.0 * units::kPi, 0.1);
}

}  // namespace
}  // namespace angio::angiogram
