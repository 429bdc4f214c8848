#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "air_mesh/build/gap_boundary.hpp"
#include "air_mesh/build/gap_mesh.hpp"
#include "centerline/centerline.hpp"
#include "datasets/phantom.hpp"
#include "meshing/meshing.hpp"
#include "meshing/wall_layers.hpp"

/// The stage on vessels as they come: phantoms, and a coronary tree from X-ray angiography.
namespace angio::meshing {
namespace {

TriangleMesh read_ascii_stl(const std::filesystem::path& path) {
  std::ifstream file(path);
  TriangleMesh soup;
  for (std::string word; file >> word;) {
    if (word != "vertex") continue;
    Vec3 p;
    file >> p.x >> p.y >> p.z;
    soup.vertices.push_back(p);
  }
  for (int v = 0; v + 2 < int(soup.vertices.size()); v += 3)
    soup.triangles.push_back({v, v + 1, v + 2});
  return soup;
}

void expect_sound_lumen(const LumenMesh& lumen, const CenterlineTree& tree) {
  EXPECT_TRUE(lumen.watertight);
  EXPECT_EQ(lumen.self_intersection_count, 0);
  EXPECT_GT(lumen.min_angle_degrees, 20.0);
  EXPECT_EQ(boundary_loops(lumen.open).size(), tree.paths.size() + 1);
}

void expect_sound_setup(const BalloonSetup& setup, const LumenMesh& lumen) {
  EXPECT_EQ(count_intersections(setup.balloon.start, lumen.capped), 0);
  EXPECT_EQ(surface_topology(setup.region.mesh).component_count, 1);
  EXPECT_EQ(surface_topology(setup.region.mesh).nonmanifold_edge_count, 0);
  const TetMesh& air = setup.air.tets;
  ASSERT_EQ(air.vertices.size(),
            setup.balloon.start.vertices.size() + setup.region.mesh.vertices.size());
  double sum = 0.0;
  for (const Tet& t : air.tets) {
    const double volume =
        tet_volume(air.vertices[std::size_t(t[0])], air.vertices[std::size_t(t[1])],
                   air.vertices[std::size_t(t[2])], air.vertices[std::size_t(t[3])]);
    EXPECT_GT(volume, 0.0);
    sum += volume;
  }
  const auto gap = air_mesh::close_region(setup.region.mesh);
  ASSERT_TRUE(gap.has_value());
  EXPECT_NEAR(sum / (enclosed_volume(gap->shell) - enclosed_volume(setup.balloon.start)), 1.0,
              1e-6);
}

/// Right-handed wedges, an outside that does not cross itself, and plaque where there is a lesion.
void expect_sound_wall(const ContactRegion& region, const CenterlineTree& tree,
                       const std::vector<centerline::Lesion>& lesions) {
  std::vector<NarrowStretch> stretches;
  for (const centerline::Lesion& lesion : lesions)
    if (lesion.is_stenosis)
      stretches.push_back(
          {lesion.path_id, lesion.proximal_mm, lesion.distal_mm, lesion.reference_diameter_mm});
  const WallLayers wall = build_wall_layers(region, tree, stretches, {});
  double least = 1.0;
  for (const auto& wedge : wall.wedges)
    least = std::min(least, least_corner_determinant(wall.vertices, wedge));
  EXPECT_GT(least, 0.0);
  EXPECT_EQ(count_self_intersections({wall.vertices, wall.outer_triangles}), 0);
  EXPECT_EQ(std::count(wall.tissue.begin(), wall.tissue.end(), WallTissue::plaque) > 0,
            !stretches.empty());
}

void expect_balloon_at_the_worst_lesion(const LumenMesh& lumen, const CenterlineTree& tree) {
  const auto lesions = centerline::find_lesions(tree, {});
  ASSERT_FALSE(lesions.empty());
  const centerline::Lesion& lesion = lesions.front();
  const auto path = std::find_if(tree.paths.begin(), tree.paths.end(),
                                 [&](const auto& p) { return p.id == lesion.path_id; });
  ASSERT_NE(path, tree.paths.end());
  const BalloonSetup setup = place_balloon(lumen, tree, *path, lesion.abscissa_mm, lesion.length_mm,
                                           lesion.reference_diameter_mm, {});
  expect_sound_setup(setup, lumen);
  expect_sound_wall(setup.region, tree, lesions);
}

class Phantoms : public testing::TestWithParam<const char*> {};

TEST_P(Phantoms, AreMeshedAndTakeABalloon) {
  const auto phantom = datasets::make_phantom_surface(datasets::parse_phantom(GetParam()));
  const CenterlineTree& tree = phantom.truth.tree;
  const LumenMesh lumen = mesh_lumen(phantom.surface, tree, {});
  expect_sound_lumen(lumen, tree);
  EXPECT_LT(enclosed_volume(lumen.capped), enclosed_volume(phantom.surface));
  expect_balloon_at_the_worst_lesion(lumen, tree);
}

TEST(FoldedBalloon, GoesIntoACoronary) {
  const auto phantom = datasets::make_phantom_surface(datasets::parse_phantom("coronary"));
  const CenterlineTree& tree = phantom.truth.tree;
  const LumenMesh lumen = mesh_lumen(phantom.surface, tree, {});
  const centerline::Lesion lesion = centerline::find_lesions(tree, {}).front();
  const auto path = std::find_if(tree.paths.begin(), tree.paths.end(),
                                 [&](const auto& p) { return p.id == lesion.path_id; });
  BalloonOptions options;
  options.folds = 3;
  const BalloonSetup setup = place_balloon(lumen, tree, *path, lesion.abscissa_mm, lesion.length_mm,
                                           lesion.reference_diameter_mm, options);
  EXPECT_EQ(count_self_intersections(setup.balloon.start), 0);
  expect_sound_setup(setup, lumen);
}

INSTANTIATE_TEST_SUITE_P(All, Phantoms,
                         testing::Values("straight", "unilateral", "bilateral", "ytype",
                                         "coronary"),
                         [](const auto& phantom) { return std::string(phantom.param); });

TEST(CoronaryFromXRay, IsMeshedAndTakesABalloon) {
  const char* data = std::getenv("ANGIO_DATA");
  if (!data) GTEST_SKIP() << "ANGIO_DATA is not set";
  const TriangleMesh surface =
      read_ascii_stl(std::filesystem::path(data) / "coronary-lumen-xra" / "lumen.stl");
  ASSERT_GT(surface.triangles.size(), 10000U);
  const CenterlineTree tree = centerline::extract_centerline(surface, {}).tree;
  const LumenMesh lumen = mesh_lumen(surface, tree, {});
  expect_sound_lumen(lumen, tree);
  // The ends that are cut off hold about one radius of each outlet only.
  EXPECT_NEAR(enclosed_volume(lumen.capped) / enclosed_volume(surface), 1.0, 0.03);
  expect_balloon_at_the_worst_lesion(lumen, tree);
}

}  // namespace
}  // namespace angio::meshing
