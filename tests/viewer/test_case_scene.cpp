#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.hpp"
#include "testing/viewer/case_folder.hpp"
#include "testing/viewer/report_content.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/case_scene.hpp"

namespace angio::viewer {
namespace {
using formats::GltfBody;
using formats::GltfScene;
using test::TemporaryFolder;

const GltfBody& body_of(const GltfScene& scene, const std::string& name) {
  const auto found = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                  [&](const GltfBody& body) { return body.name == name; });
  if (found == scene.bodies.end()) throw InputError("no body " + name);
  return *found;
}

TEST(CaseScene, BalloonAndWallMoveThroughEveryWrittenFrame) {
  const TemporaryFolder folder;
  test::write_case(folder.path());
  const GltfScene scene = read_case_scene(folder.path());
  EXPECT_EQ(scene.times_s, (std::vector<double>{0.0, 1.5, 3.0, 4.5, 6.0, 7.5}));
  const auto moments = test::make_report_content().moments;  // two frames of each
  const GltfBody& balloon = body_of(scene, "balloon");
  ASSERT_EQ(balloon.later.size(), 5u);
  EXPECT_EQ(balloon.mesh.vertices, moments[0].balloon.vertices);
  EXPECT_EQ(balloon.later[1], moments[1].balloon.vertices);
  EXPECT_EQ(balloon.later[4], moments[2].balloon.vertices);
  const GltfBody& wall = body_of(scene, "wall");
  EXPECT_EQ(wall.later[2], moments[1].wall.vertices);
}

TEST(CaseScene, LumenIsWhatTheWallLeavesOver) {
  const TemporaryFolder folder;
  test::write_case(folder.path());
  const auto content = test::make_report_content();
  const GltfScene scene = read_case_scene(folder.path());
  std::size_t rest = 0;
  for (const GltfBody& body : scene.bodies)
    if (body.name == "lumen") rest = body.mesh.triangles.size();
  EXPECT_EQ(rest + body_of(scene, "wall").mesh.triangles.size(), content.lumen.triangles.size());
}

TEST(CaseScene, CaseWithoutSimulationIsNoInput) {
  const TemporaryFolder folder;
  test::write_case(folder.path());
  std::filesystem::remove_all(folder / "simulation");
  try {
    read_case_scene(folder.path());
    FAIL() << "a scene of nothing";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::no_input);
  }
}

}  // namespace
}  // namespace angio::viewer
