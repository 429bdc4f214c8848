#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/files.hpp"
#include "testing/viewer/case_folder.hpp"
#include "testing/viewer/png.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/detail/case_data.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/detail/picture.hpp"
#include "viewer/view.hpp"

namespace angio::viewer {
namespace {
using test::TemporaryFolder;
using test::write_case;
using testing::HasSubstr;

detail::Picture take_screenshot(const TemporaryFolder& folder, int frame) {
  ViewOptions options;
  options.width = 480;
  options.height = 320;
  options.frame = frame;
  options.screenshot = folder / "view.png";
  view_case(folder.path(), options);
  return angio::test::picture_from_png(read_text(options.screenshot));
}

int count_blue(const detail::Picture& picture) {
  int blue = 0;
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3)
    blue += picture.rgb[i + 2] > picture.rgb[i] + 30 ? 1 : 0;
  return blue;
}

ExitCode exit_code_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.exit_code();
  }
  return ExitCode::done;
}

TEST(View, ScreenshotShowsTheBalloonWhichIsLargestAtPeak) {
  const TemporaryFolder folder;
  write_case(folder.path());
  const detail::Picture start = take_screenshot(folder, 0);
  const detail::Picture peak = take_screenshot(folder, -1);
  EXPECT_EQ(peak.width, 480);
  EXPECT_EQ(peak.height, 320);
  EXPECT_GT(count_blue(start), 100);
  EXPECT_GT(count_blue(peak), 2 * count_blue(start));
}

TEST(View, ScreenshotIsTheSameEveryTime) {
  const TemporaryFolder folder;
  write_case(folder.path());
  EXPECT_EQ(take_screenshot(folder, 120).rgb, take_screenshot(folder, 120).rgb);
}

TEST(View, CaseWithoutSimulationOrScanIsShown) {
  const TemporaryFolder folder;
  formats::write_surface(folder / "meshing/lumen.vtp", {test::make_tube({}), {}, {}});
  const detail::Picture picture = take_screenshot(folder, -1);
  const auto [low, high] = std::minmax_element(picture.rgb.begin(), picture.rgb.end());
  EXPECT_GT(*high - *low, 100);
}

TEST(View, MissingOrEmptyCaseIsNoInput) {
  const TemporaryFolder folder;
  EXPECT_EQ(exit_code_of([&] { view_case(folder / "none", {}); }), ExitCode::no_input);
  EXPECT_EQ(exit_code_of([&] { view_case(folder.path(), {}); }), ExitCode::no_input);
}

TEST(View, WindowWithoutADisplayIsUnavailable) {
  const TemporaryFolder folder;
  formats::write_surface(folder / "meshing/lumen.vtp", {test::make_tube({}), {}, {}});
  const char* display = std::getenv("DISPLAY");
  const std::string before = display ? display : "";
  setenv("DISPLAY", ":48613", 1);
  EXPECT_EQ(exit_code_of([&] { view_case(folder.path(), {}); }), ExitCode::unavailable);
  const DisplayStatus status = display_status();
  EXPECT_FALSE(status.window);
  EXPECT_THAT(status.description, HasSubstr(":48613 does not answer"));
  if (display)
    setenv("DISPLAY", before.c_str(), 1);
  else
    unsetenv("DISPLAY");
}

TEST(View, KeysArePressedBeforeTheScreenshot) {
  const TemporaryFolder folder;
  write_case(folder.path());
  ViewOptions options;
  options.screenshot = folder / "view.png";
  options.keys = {"n"};
  view_case(folder.path(), options);
  const detail::Picture picture = angio::test::picture_from_png(read_text(options.screenshot));
  EXPECT_EQ(picture.width, options.width);
  options.keys = {};
  view_case(folder.path(), options);
  EXPECT_GT(count_blue(angio::test::picture_from_png(read_text(options.screenshot))),
            count_blue(picture) + 500);
  options.keys = {"no-such-key"};
  EXPECT_EQ(exit_code_of([&] { view_case(folder.path(), options); }), ExitCode::usage);
}

TEST(View, SignalClosesTheOpenWindowAtOnce) {
  if (!detail::find_xvfb()) GTEST_SKIP() << "Xvfb is not installed";
  const TemporaryFolder folder;
  write_case(folder.path());
  const detail::OffscreenDisplay display;
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction before = {};
    sigaction(signal, nullptr, &before);
    std::chrono::steady_clock::time_point sent;
    std::thread sender([&] {
      struct sigaction now = before;
      while (now.sa_handler == before.sa_handler) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        sigaction(signal, nullptr, &now);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1500));
      sent = std::chrono::steady_clock::now();
      kill(getpid(), signal);
    });
    view_case(folder.path(), {});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - sent;
    sender.join();
    EXPECT_LT(took.count(), 30.0);  // nobody else closes it: without the signal it stays open
    struct sigaction after = {};
    sigaction(signal, nullptr, &after);
    EXPECT_EQ(after.sa_handler, before.sa_handler);
  }
}

TEST(CaseData, FramesAndTheirRowsAreFound) {
  const TemporaryFolder folder;
  write_case(folder.path());
  const detail::CaseData data = detail::read_case(folder.path());
  ASSERT_EQ(data.frames.size(), 6u);
  EXPECT_EQ(data.frames[2].frame, 120);
  EXPECT_DOUBLE_EQ(data.frames[2].time_s, 3.0);
  EXPECT_EQ(data.frames[2].vessel.filename(), "vessel_000120.vtp");
  EXPECT_EQ(data.paths.size(), 1u);
  ASSERT_TRUE(data.scan);
  EXPECT_EQ(detail::peak_frame(data), 3u);  // 4.5 s, in the hold at 8 atm
  EXPECT_EQ(detail::nearest_frame(data.frames, 70), 1u);
  const std::string text = detail::describe_frame(data, data.frames[3]);
  for (const char* words : {"frame 180", "4.500 s", "hold", "8.00 atm"})
    EXPECT_THAT(text, HasSubstr(words));
}

TEST(CaseData, CollectionNamesAreUnescapedAndDamageIsRefused) {
  const TemporaryFolder folder;
  formats::write_collection(folder / "a.pvd", {{0.5, 0, "a&b/balloon_000007.vtp"},
                                               {0.5, 1, "a&b/vessel_000007.vtp"},
                                               {0.5, 3, "a&b/guidewire_000007.vtp"}});
  const auto frames = detail::read_frame_list(folder / "a.pvd");
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].frame, 7);
  EXPECT_EQ(frames[0].balloon, folder / "a&b/balloon_000007.vtp");
  EXPECT_EQ(frames[0].guidewire, folder / "a&b/guidewire_000007.vtp");
  write_text_atomically(folder / "b.pvd", "<DataSet file=\"balloon_1.vtp\"/>");
  EXPECT_THROW(detail::read_frame_list(folder / "b.pvd"), InputError);
}

}  // namespace
}  // namespace angio::viewer
