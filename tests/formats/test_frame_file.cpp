#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

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

// Every second thread writes where it cannot: the others are not told of that.
TEST(FrameFile, ManyThreadsWriteAtOnceAndEachIsToldOfItsOwnFailures) {
  constexpr int kThreads = 8, kFrames = 40;
  const test::TemporaryFolder folder;
  std::vector<int> written(kThreads), failed(kThreads);
  std::vector<std::thread> threads;
  for (std::size_t n = 0; n < kThreads; ++n)
    threads.emplace_back([&, n] {
      const std::string place = n % 2 == 0 ? "" : std::string(300, 'x');  // no name is so long
      for (int frame = 0; frame < kFrames; ++frame) try {
          const std::string name = place + std::to_string(n) + "_" + std::to_string(frame) + ".vtp";
          write_frame_surface(folder / name, {kTetrahedron, {}, {}}, {0.1 * frame, 1.0, "hold"});
          ++written[n];
        } catch (const IoError&) {
          ++failed[n];
        }
    });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t n = 0; n < kThreads; ++n)
    EXPECT_EQ(n % 2 == 0 ? written[n] : failed[n], kFrames) << n;
  EXPECT_EQ(read_frame_moment(folder / "0_7.vtp").time_s, 0.1 * 7);
}

TEST(FrameFile, OtherSurfacesHaveNoMoment) {
  const test::TemporaryFolder folder;
  write_surface(folder / "a.vtp", {kTetrahedron, {}, {}});
  EXPECT_THROW((void)read_frame_moment(folder / "a.vtp"), InputError);
  EXPECT_THROW((void)read_frame_moment(folder / "none.vtp"), InputError);
}

}  // namespace
}  // namespace angio::formats
