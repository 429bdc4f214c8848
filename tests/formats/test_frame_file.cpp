#include <gtest/gtest.h>

#include "core/error.hpp"
#include "formats/frame_file.hpp"
#include "testing/temporary_folder.hpp"

namespace angio::formats {
namespace {

const TriangleMesh kTetrahedron{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};

TEST(FrameFile, SaysItsMomentAndIsASurfaceAsAnyOther) {
  const test::TemporaryFolder folder;
  write_frame_surface(folder / "a.vtp", {kTetrahedron, {}, {}}, {0.625, 3.25, "inflate"});
  const FrameMoment moment = read_frame_moment(folder / "a.vtp");
  EXPECT_EQ(moment.time_s, 0.625);
  EXPECT_EQ(moment.pressure_atm, 3.25);
  EXPECT_EQ(moment.phase, "inflate");
  const SurfaceData back = read_surface(folder / "a.vtp");
  EXPECT_EQ(back.mesh.vertices, kTetrahedron.vertices);
  EXPECT_EQ(back.mesh.triangles, kTetrahedron.triangles);
  EXPECT_TRUE(back.point_arrays.empty());
}

TEST(FrameFile, OtherSurfacesHaveNoMoment) {
  const test::TemporaryFolder folder;
  write_surface(folder / "a.vtp", {kTetrahedron, {}, {}});
  EXPECT_THROW((void)read_frame_moment(folder / "a.vtp"), InputError);
  EXPECT_THROW((void)read_frame_moment(folder / "none.vtp"), InputError);
}

}  // namespace
}  // namespace angio::formats
