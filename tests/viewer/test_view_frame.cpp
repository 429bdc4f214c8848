#include <gtest/gtest.h>

#include <cmath>

#include "testing/viewer/shapes.hpp"
#include "viewer/detail/view_frame.hpp"

namespace angio::viewer::detail {
namespace {
using test::make_cube;
using test::make_path;
using test::make_tube;

void expect_orthonormal(const ViewFrame& frame) {
  EXPECT_NEAR(norm(frame.direction), 1.0, 1e-9);
  EXPECT_NEAR(norm(frame.up), 1.0, 1e-9);
  EXPECT_NEAR(dot(frame.direction, frame.up), 0.0, 1e-9);
}

void expect_inside(const ViewFrame& frame, const std::vector<Vec3>& points) {
  for (const Vec3& point : points) {
    EXPECT_LE(std::abs(dot(point - frame.focus, frame.right())), frame.half_width_mm);
    EXPECT_LE(std::abs(dot(point - frame.focus, frame.up)), frame.half_height_mm);
  }
}

TEST(FrameTree, HoldsTheWholeMesh) {
  const TriangleMesh mesh = make_tube({.bend_mm = 8.0});
  const ViewFrame frame = frame_tree(mesh);
  expect_orthonormal(frame);
  expect_inside(frame, mesh.vertices);
}

TEST(FrameTree, LooksAtTheBroadSideFromTheFrontHeadUp) {
  TriangleMesh sheet;  // flat in y, so seen along y
  for (int i = 0; i <= 20; ++i)
    for (int k = 0; k <= 30; ++k)
      sheet.vertices.push_back({double(i), 0.3 * ((i + k) % 2), double(k)});
  const ViewFrame frame = frame_tree(sheet);
  EXPECT_NEAR(frame.direction.y, 1.0, 1e-3);
  EXPECT_NEAR(frame.up.z, 1.0, 1e-3);
  EXPECT_NEAR(frame.right().x, 1.0, 1e-3);  // the patient's left at the right of the picture
}

TEST(FrameTree, LooksAlongWhatIsAskedForWhereTheTreeIsHardlyDeeper) {
  const TriangleMesh straight = make_tube({.depth = 0.0, .bend_mm = 0.0}),
                     bent = make_tube({.depth = 0.0, .bend_mm = 30.0});
  const Vec3 across = normalized(Vec3{0.6, 0.8, 0.0});
  EXPECT_NEAR(dot(frame_tree(straight, across).direction, across), 1.0, 1e-9);
  const Vec3 flat = frame_tree(bent).direction;
  const Vec3 in_its_plane = normalized(cross(flat, frame_tree(bent).up));
  EXPECT_NEAR(dot(frame_tree(bent, in_its_plane).direction, flat), 1.0, 1e-9);
}

TEST(IncludeCircle, OpensTheFrameAsFarAsNeeded) {
  const TriangleMesh mesh = make_tube({.bend_mm = 8.0});
  const ViewFrame frame = frame_tree(mesh);
  ViewFrame same = frame, open = frame;
  include_circle(same, frame.focus, 0.5 * std::min(frame.half_width_mm, frame.half_height_mm));
  EXPECT_EQ(same.half_width_mm, frame.half_width_mm);
  EXPECT_EQ(same.half_height_mm, frame.half_height_mm);
  const Vec3 edge = frame.focus + frame.half_width_mm * frame.right();
  include_circle(open, edge, 5.0);
  expect_inside(open, mesh.vertices);
  expect_inside(open, {edge + 5.0 * open.right(), edge + 5.0 * open.up, edge - 5.0 * open.up});
  EXPECT_LT(open.half_width_mm, frame.half_width_mm + 5.0);
}

TEST(FrameTree, MeshesWithoutExtentGiveAFrame) {
  TriangleMesh point;
  point.vertices = {{1, 2, 3}};
  for (const TriangleMesh& mesh : {TriangleMesh{}, point}) {
    const ViewFrame frame = frame_tree(mesh);
    expect_orthonormal(frame);
    EXPECT_GT(frame.half_width_mm, 0.0);
    EXPECT_GT(frame.half_height_mm, 0.0);
  }
}

TEST(FrameLesion, LooksAcrossTheVesselWithTheFlowFromLeftToRight) {
  const test::TubeShape shape;
  const CenterlinePath path = make_path(shape);
  const ViewFrame frame = frame_lesion(make_tube(shape), {}, path, path.abscissa[60]);
  expect_orthonormal(frame);
  const Vec3 flow = sample(path, path.abscissa[60]).tangent;
  EXPECT_NEAR(dot(frame.direction, flow), 0.0, 0.05);
  EXPECT_GT(dot(frame.right(), flow), 0.99);
  expect_inside(frame, make_tube(shape).vertices);
}

/// A tube whose front half is pressed in towards +x at its middle, at any angle about its axis.
TriangleMesh make_one_sided(double angle) {
  TriangleMesh mesh = make_tube({.depth = 0.0, .bend_mm = 0.0});
  const Vec3 side{std::cos(angle), std::sin(angle), 0.0};
  for (Vec3& vertex : mesh.vertices) {
    const double out = dot(vertex, side);
    const double press = std::exp(-std::pow((vertex.z - 15.0) / 3.0, 2));
    if (out > 0.0) vertex -= (0.8 * press * out) * side;
  }
  return mesh;
}

TEST(FrameLesion, ShowsAOneSidedStenosisInProfile) {
  const CenterlinePath path = make_path({.depth = 0.0, .bend_mm = 0.0});
  for (const double angle : {0.0, 0.7, 2.0, 4.4}) {
    const ViewFrame frame = frame_lesion(make_one_sided(angle), {}, path, 15.0);
    const Vec3 side{std::cos(angle), std::sin(angle), 0.0};
    EXPECT_NEAR(dot(frame.direction, side), 0.0, 0.25) << angle;
  }
}

TEST(FrameLesion, LooksFromWhereNoOtherVesselIsInTheWay) {
  const CenterlinePath path = make_path({.depth = 0.3, .bend_mm = 0.0});
  const TriangleMesh wall = make_tube({.depth = 0.3, .bend_mm = 0.0});
  for (const double y : {-6.0, 6.0}) {
    TriangleMesh neighbor = wall;
    for (Vec3& vertex : neighbor.vertices) vertex.y += y;
    const ViewFrame frame = frame_lesion(wall, neighbor, path, 15.0);
    EXPECT_GT(frame.direction.y * y, -0.7 * std::abs(y)) << y;  // not looking through it
  }
}

TEST(Surroundings, LeaveOutTheWallAndWhatIsFar) {
  TriangleMesh lumen = make_cube();
  const TriangleMesh far = make_cube({100, 0, 0});
  const int first = int(lumen.vertices.size());
  lumen.vertices.insert(lumen.vertices.end(), far.vertices.begin(), far.vertices.end());
  for (Triangle triangle : far.triangles) {
    for (int& corner : triangle) corner += first;
    lumen.triangles.push_back(triangle);
  }
  EXPECT_EQ(surroundings(lumen, {}, {}, 10.0).triangles.size(), 12u);
  EXPECT_EQ(surroundings(lumen, make_cube(), {}, 1e9).triangles.size(), 12u);
  EXPECT_EQ(surroundings(lumen, make_cube(), {}, 10.0).triangles.size(), 0u);
}

TEST(Bounds, AreTheBox) {
  const Bounds box = bounds(make_cube({2, 3, 4}));
  EXPECT_EQ(box.center, (Vec3{2.5, 3.5, 4.5}));
  EXPECT_NEAR(box.radius_mm, 0.5 * std::sqrt(3.0), 1e-12);
}

}  // namespace
}  // namespace angio::viewer::detail
