#include <gtest/gtest.h>
#include <vtkActorCollection.h>
#include <vtkCommand.h>
#include <vtkProperty.h>
#include <vtkRenderWindowInteractor.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <thread>

#include "core/error.hpp"
#include "formats/files.hpp"
#include "formats/vtk_messages.hpp"
#include "testing/viewer/case_folder.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/window/closing_signals.hpp"
#include "viewer/window/live_window.hpp"
#include "viewer/window/scene_view.hpp"

namespace angio::viewer::window {
namespace {
using detail::Picture;
using viewer::test::TemporaryFolder;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A balloon that follows at once: it widens with the pressure, and goes where it is sent.
LiveState state_for(const TriangleMesh& balloon, const TriangleMesh& wall, const LiveAim& aim) {
  LiveState state;
  state.shape.balloon = balloon;
  for (Vec3& p : state.shape.balloon.vertices)
    p = (1.0 + 0.15 * aim.pressure_atm) * p + Vec3{0, 0, aim.place_mm};
  state.shape.wall = wall;
  state.shape.contact_pressure_kpa.assign(wall.vertices.size(), 50.0 * aim.pressure_atm);
  state.pressure_atm = aim.pressure_atm;
  state.volume_mm3 = std::pow(1.0 + 0.15 * aim.pressure_atm, 3);
  state.place_mm = aim.place_mm;
  return state;
}

class LiveWindowTest : public testing::Test {
 protected:
  LiveWindowTest() {
    viewer::test::write_case(folder_.path());
    const fs::path frames = folder_ / "simulation/frames";
    fs::copy_file(frames / "balloon_000000.vtp", folder_ / "meshing/balloon.vtp");
    fs::copy_file(frames / "vessel_000000.vtp", folder_ / "meshing/region.vtp");
    const TriangleMesh balloon = formats::read_surface(folder_ / "meshing/balloon.vtp").mesh,
                       wall = formats::read_surface(folder_ / "meshing/region.vtp").mesh;
    drive_.first = state_for(balloon, wall, {});
    drive_.frame_s = 0.005;
    drive_.most_pressure_atm = 8.0;
    drive_.least_place_mm = -4.0;
    drive_.most_place_mm = 6.0;
    drive_.step = [=](const LiveAim& aim) { return state_for(balloon, wall, aim); };
    options_.width = 700;
    options_.height = 500;
  }
  void open() { window_ = std::make_unique<LiveWindow>(folder_.path(), drive_, options_); }
  /// Ticks until a frame shows what was asked for.
  void wait_for_aim() {
    const auto reached = [&] {
      const LiveState& shown = *window_->shown();
      return std::abs(shown.pressure_atm - window_->aim().pressure_atm) < 1e-9 &&
             std::abs(shown.place_mm - window_->aim().place_mm) < 1e-9;
    };
    for (int i = 0; i < 400 && !reached(); ++i) {
      window_->tick();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(reached());
  }
  static int changed(const Picture& a, const Picture& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.rgb.size(); i += 3)
      count += std::abs(int(a.rgb[i]) - int(b.rgb[i])) > 12 ? 1 : 0;
    return count;
  }
  void click(const PixelBox& track, double share) {
    vtkRenderWindowInteractor* mouse = window_->interactor();
    mouse->SetEventInformation(track.left + int(share * track.width),
                               track.bottom + track.height / 2);
    for (const unsigned long event : {vtkCommand::MouseMoveEvent, vtkCommand::LeftButtonPressEvent,
                                      vtkCommand::LeftButtonReleaseEvent})
      mouse->InvokeEvent(event);
  }

  TemporaryFolder folder_;
  detail::OffscreenDisplay display_;
  formats::VtkMessages messages_;
  LiveDrive drive_;
  LiveOptions options_;
  std::unique_ptr<LiveWindow> window_;
};

TEST_F(LiveWindowTest, KeysInflateMoveHoldAndLetDown) {
  open();
  const Picture start = window_->picture();
  for (int i = 0; i < 4; ++i) window_->press("Up");
  EXPECT_DOUBLE_EQ(window_->aim().pressure_atm, 2.0);
  wait_for_aim();
  EXPECT_GT(window_->shown()->volume_mm3, drive_.first.volume_mm3);
  const Picture full = window_->picture();
  EXPECT_GT(changed(start, full), 200) << "the balloon is larger, the wall coloured";
  window_->press("Right");
  window_->press("Right");
  EXPECT_DOUBLE_EQ(window_->aim().place_mm, 1.0);
  wait_for_aim();
  EXPECT_GT(changed(full, window_->picture()), 100) << "the balloon has moved";
  window_->press("Prior");
  EXPECT_DOUBLE_EQ(window_->aim().pressure_atm, 8.0);
  window_->press("space");
  EXPECT_DOUBLE_EQ(window_->aim().pressure_atm, window_->shown()->pressure_atm);
  window_->press("Next");
  window_->press("Left");
  window_->press("Left");
  wait_for_aim();
  EXPECT_LT(changed(start, window_->picture()), 200) << "all is as it was";
}

TEST_F(LiveWindowTest, NoRingMarksAPlaceThatNobodyChose) {
  const detail::CaseData data = detail::read_case(folder_.path());
  const TreatedLine line = read_treated_line(folder_.path(), data);
  SceneView scene(data, line, nullptr);
  const auto rings_seen = [&] {
    int count = 0;
    vtkActorCollection* actors = scene.renderer()->GetActors();
    actors->InitTraversal();
    while (vtkActor* actor = actors->GetNextActor()) {
      const auto* color = actor->GetProperty()->GetColor();
      const bool is_yellow = color[0] > 0.9 && color[1] > 0.8 && color[2] < 0.3;
      count += is_yellow && actor->GetVisibility() != 0 ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(rings_seen(), 0);
  scene.set_cursor(line.start_mm());
  EXPECT_EQ(rings_seen(), 1);
}

TEST_F(LiveWindowTest, AimsStayWithinTheirRanges) {
  open();
  for (int i = 0; i < 40; ++i) window_->press("Up");
  for (int i = 0; i < 40; ++i) window_->press("Right");
  EXPECT_DOUBLE_EQ(window_->aim().pressure_atm, 8.0);
  EXPECT_DOUBLE_EQ(window_->aim().place_mm, 6.0);
  for (int i = 0; i < 80; ++i) window_->press("Down");
  for (int i = 0; i < 80; ++i) window_->press("Left");
  EXPECT_DOUBLE_EQ(window_->aim().pressure_atm, 0.0);
  EXPECT_DOUBLE_EQ(window_->aim().place_mm, -4.0);
}

TEST_F(LiveWindowTest, SlidersDoWhatKeysDo) {
  open();
  window_->picture();
  click(window_->pressure_track(), 0.5);
  EXPECT_NEAR(window_->aim().pressure_atm, 4.0, 0.4);
  click(window_->place_track(), 0.9);
  EXPECT_NEAR(window_->aim().place_mm, 5.0, 0.6);
  wait_for_aim();
}

TEST_F(LiveWindowTest, EndsAfterItsTimeAndTellsBothRates) {
  options_.seconds = 1.5;
  open();
  window_->press("Prior");
  const LiveRates rates = window_->run();
  EXPECT_GE(rates.seconds, 1.5);
  EXPECT_LT(rates.seconds, 30.0);  // 1.6 s on a machine that does nothing else
  EXPECT_GT(rates.frame_count, 0);
  EXPECT_GT(rates.picture_count, 0);
  EXPECT_LE(rates.frames_per_second(), 1.1 / drive_.frame_s) << "no faster than real time";
  EXPECT_DOUBLE_EQ(rates.last.pressure_atm, 8.0);
}

TEST_F(LiveWindowTest, EndsWithItsPictureWhereNoTimeIsGiven) {
  options_.screenshot = folder_.path() / "live.png";
  open();
  EXPECT_LT(window_->run().seconds, 30.0);
  EXPECT_TRUE(std::filesystem::exists(options_.screenshot));
}

TEST_F(LiveWindowTest, ASignalOrQClosesItAtOnce) {
  const ClosingSignals signals;
  for (const int signal : {SIGINT, SIGTERM, 0}) {
    open();
    std::thread later([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      if (signal != 0) raise(signal);
    });
    if (signal == 0) window_->press("q");
    const auto start = Clock::now();
    window_->run();
    later.join();
    EXPECT_LT(std::chrono::duration<double>(Clock::now() - start).count(), 30.0);
    EXPECT_TRUE(window_->is_closing());
    window_.reset();
    if (signal != 0) break;  // the note of a signal stays as long as the signals are caught
  }
}

TEST_F(LiveWindowTest, WhatTheSolverThrowsIsThrown) {
  drive_.step = [](const LiveAim&) -> LiveState { throw InputError("it cannot go on"); };
  options_.seconds = 0.5;
  open();
  EXPECT_THROW(window_->run(), InputError);
}

TEST(LiveKeys, AreKnownByTheirNames) {
  for (const char* key : {"Up", "Down", "Left", "Right", "Prior", "Next", "space", "b", "q"})
    EXPECT_TRUE(LiveWindow::knows_key(key)) << key;
  EXPECT_FALSE(LiveWindow::knows_key("z"));
}

}  // namespace
}  // namespace angio::viewer::window
