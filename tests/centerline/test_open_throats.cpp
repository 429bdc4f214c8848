#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "centerline/centerline.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/open_throats.hpp"
#include "core/units.hpp"
#include "testing/shapes.hpp"
#include "tests/centerline/straight_lines.hpp"

namespace angio::centerline {
namespace {

constexpr double kRadius = 3.0, kLength = 60.0;

/// A tube along z, of a radius for each z, turned off the grid. All in mm.
TriangleMesh tube(double angle, const std::function<double(double)>& radius) {
  TriangleMesh mesh = tests::make_tube(1.0, kLength, 481, 48);
  for (Vec3& p : mesh.vertices) {
    const double x = radius(p.z) * p.x + 0.37;
    p = {std::cos(angle) * x - std::sin(angle) * p.z, radius(p.z) * p.y + 0.41,
         std::sin(angle) * x + std::cos(angle) * p.z};
  }
  return mesh;
}

/// Its radius falls to `throat` in its middle, within `half` on each side.
TriangleMesh narrowed_tube(double angle, double throat, double half) {
  return tube(angle, [=](double z) {
    return kRadius * test::narrowed(z, 0.5 * kLength, half, 1.0 - throat / kRadius);
  });
}

/// It is `throat` narrow over a length in its middle, with a bead of a radius in there.
TriangleMesh beaded_tube(double angle, double throat, double length, double bead) {
  return tube(angle, [=](double z) {
    const double off = std::abs(z - 0.5 * kLength);
    const double shoulder = std::min(kRadius, throat + std::max(0.0, off - 0.5 * length));
    return std::max(shoulder, off < 1.5 ? bead * std::cos(units::kPi * off / 3.0) : 0.0);
  });
}

TriangleMesh both(TriangleMesh one, const TriangleMesh& other) {
  const int count = int(one.vertices.size());
  one.vertices.insert(one.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles)
    one.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  return one;
}

int part_count(const Volume<float>& level_set) { return find_lumen_pieces(level_set).piece_count; }

TEST(OpenThroats, AThroatNarrowerThanAVoxelStaysOneLumen) {
  for (const double angle : {0.3, 0.8, 1.3}) {
    SCOPED_TRACE(angle);
    const SurfaceWall wall(close_surface(narrowed_tube(angle, 0.3, 9.0)).mesh);
    Volume<float> level_set = voxelize(wall.mesh(), 1.0);
    ASSERT_GT(part_count(level_set), 1);
    const Volume<float> before = level_set;
    EXPECT_GT(open_throats(level_set, wall), 0);
    EXPECT_EQ(part_count(level_set), 1);
    for (std::size_t v = 0; v < level_set.values.size(); ++v) {  // within a voxel of the lumen
      if (level_set.values[v] == before.values[v]) continue;
      EXPECT_LT(before.values[v], std::sqrt(3.0));
    }
  }
}

TEST(OpenThroats, AThroatNarrowerThanAskedForStaysShut) {
  const SurfaceWall wall(close_surface(narrowed_tube(0.3, 0.3, 9.0)).mesh);
  for (const double least : {0.5, 1.5}) {  // the throat: 0.6 mm wide
    Volume<float> level_set = voxelize(wall.mesh(), 1.0);
    open_throats(level_set, wall, least);
    EXPECT_EQ(part_count(level_set) > 1, least > 0.6);
  }
}

TEST(OpenThroats, CrumbsInALongThroatDoNotShutIt) {
  for (const double angle : {0.3, 0.8, 1.3})
    for (const double bead : {0.0, 1.0, 1.4}) {
      SCOPED_TRACE(testing::Message() << angle << ", bead of " << bead << " mm");
      const SurfaceWall wall(close_surface(beaded_tube(angle, 0.3, 8.0, bead)).mesh);
      Volume<float> level_set = voxelize(wall.mesh(), 1.0);
      ASSERT_GT(part_count(level_set), 1);
      open_throats(level_set, wall);
      EXPECT_EQ(part_count(level_set), 1);
    }
}

/// The parts of the lumen that hold the places, each by the index of the piece; -1 in none.
std::vector<int> pieces_at(const Volume<float>& level_set, const std::vector<Vec3>& places) {
  const LumenPieces found = find_lumen_pieces(level_set);
  std::vector<int> result;
  for (const Vec3& place : places) {
    int at = -1;
    for (std::size_t n = 0; n < found.pieces.size(); ++n) {
      const LumenVoxels& piece = found.pieces[n];
      if (distance(piece.position(piece.nearest(place)), place) < 1.0) at = int(n);
    }
    result.push_back(at);
  }
  return result;
}

TEST(OpenThroats, AVesselBesideAThroatStaysApart) {
  for (const double angle : {0.3, 0.8, 1.3})
    for (const double gap : {0.3, 0.5, 0.8, 1.1}) {
      SCOPED_TRACE(testing::Message() << angle << ", " << gap << " mm apart");
      const TriangleMesh throat = beaded_tube(angle, 0.3, 8.0, 0.0);
      // Across the throat: along y, and beside it along x of the tube.
      const double away = 0.3 + gap + 1.5;
      const auto turned = [&](double x, double y, double z) {
        return Vec3{std::cos(angle) * x - std::sin(angle) * z, y,
                    std::sin(angle) * x + std::cos(angle) * z};
      };
      TriangleMesh other = tests::make_tube(1.5, 40.0, 161, 32);
      for (Vec3& p : other.vertices) p = turned(0.37 + away + p.y, p.z - 20.0, 0.5 * kLength + p.x);
      const SurfaceWall wall(close_surface(both(throat, other)).mesh);
      Volume<float> level_set = voxelize(wall.mesh(), 1.0);
      const std::vector<Vec3> places{turned(0.37, 0.41, 10.0), turned(0.37 + away, 10.0, 30.0)};
      open_throats(level_set, wall);
      const std::vector<int> pieces = pieces_at(level_set, places);
      EXPECT_NE(pieces[0], pieces[1]);
      EXPECT_GE(pieces[0], 0);
      EXPECT_GE(pieces[1], 0);
    }
}

TEST(OpenThroats, NothingIsOpenedThatIsWholeOrApart) {
  // Two tubes with a wall of 0.3 mm between them, and one of them alone.
  const TriangleMesh one = tests::make_tube(kRadius, kLength, 61, 48);
  TriangleMesh other = one;
  for (Vec3& p : other.vertices) p.x += 2.0 * kRadius + 0.3;
  for (const TriangleMesh& mesh : {both(one, other), one}) {
    const SurfaceWall wall(close_surface(mesh).mesh);
    Volume<float> level_set = voxelize(wall.mesh(), 1.0);
    const int parts = part_count(level_set);
    EXPECT_EQ(open_throats(level_set, wall), 0);
    EXPECT_EQ(part_count(level_set), parts);
  }
}

TEST(OpenThroats, TheLineOfASurfaceGoesThroughItsThroat) {
  const CenterlineResult result = extract_centerline(narrowed_tube(0.3, 0.15, 3.0), {});
  EXPECT_EQ(result.tree_count, 1);
  const CenterlinePath& path = result.tree.paths.at(0);
  EXPECT_NEAR(path.abscissa.back(), kLength, 0.5);
  const std::vector<Lesion> lesions = find_lesions(result.tree, {});
  ASSERT_TRUE(lesions.at(0).is_stenosis);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 95.0, 2.0);
}

}  // namespace
}  // namespace angio::centerline
