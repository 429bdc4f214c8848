#include <gtest/gtest.h>

#include <cmath>

#include "centerline/centerline.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/open_throats.hpp"
#include "testing/shapes.hpp"
#include "tests/centerline/straight_lines.hpp"

namespace angio::centerline {
namespace {

constexpr double kRadius = 3.0, kLength = 60.0;

/// A tube along z whose radius falls to `throat` in its middle, within `half` on each side, turned
/// off the grid. All in mm.
TriangleMesh narrowed_tube(double angle, double throat, double half) {
  TriangleMesh mesh = tests::make_tube(kRadius, kLength, 481, 48);
  for (Vec3& p : mesh.vertices) {
    const double scale = test::narrowed(p.z, 0.5 * kLength, half, 1.0 - throat / kRadius);
    const double x = scale * p.x + 0.37;
    p = {std::cos(angle) * x - std::sin(angle) * p.z, scale * p.y + 0.41,
         std::sin(angle) * x + std::cos(angle) * p.z};
  }
  return mesh;
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

TEST(OpenThroats, NothingIsOpenedThatIsWholeOrApart) {
  // Two tubes with a wall of 0.3 mm between them, and one of them alone.
  TriangleMesh pair = tests::make_tube(kRadius, kLength, 61, 48);
  const int count = int(pair.vertices.size());
  const TriangleMesh one = pair;
  for (const Vec3& p : one.vertices) pair.vertices.push_back({p.x + 2.0 * kRadius + 0.3, p.y, p.z});
  for (const Triangle& t : one.triangles)
    pair.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  for (const TriangleMesh& mesh : {pair, one}) {
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
