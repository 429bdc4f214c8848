#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <thread>

#include "core/atomic_file.hpp"
#include "formats/files.hpp"
#include "testing/viewer/png.hpp"
#include "tests/viewer/view_window_test.hpp"
#include "viewer/window/closing_signals.hpp"
#include "viewer/window/view_window.hpp"

// Every action of the window, judged by the pictures and by what the window says of itself.
namespace angio::viewer::window {
namespace {
using detail::Picture;
using test::ViewWindowTest;
using testing::HasSubstr;

TEST_F(ViewWindowTest, EveryButtonIsInItsPanelAndNoTwoOverlap) {
  std::vector<PixelBox> boxes;
  for (const ActionText& text : action_table()) {
    const PixelBox box = view_->controls().button_box(text.action);
    if (box.width > 0) boxes.push_back(box);
  }
  EXPECT_GT(boxes.size(), 30u);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    EXPECT_GE(boxes[i].left, 0);
    EXPECT_GE(boxes[i].bottom, 0);
    EXPECT_LE(boxes[i].right(), 1200);
    EXPECT_LE(boxes[i].top(), 800);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_FALSE(boxes[i].left < boxes[j].right() && boxes[j].left < boxes[i].right() &&
                   boxes[i].bottom < boxes[j].top() && boxes[j].bottom < boxes[i].top());
  }
}

TEST_F(ViewWindowTest, LayersGoAndComeBackByKeyAndByButton) {
  const std::vector<std::pair<Action, Layer>> layers = {
      {Action::show_lumen, Layer::lumen},     {Action::show_wall, Layer::wall},
      {Action::show_balloon, Layer::balloon}, {Action::show_line, Layer::line},
      {Action::show_slice, Layer::slice},     {Action::show_projection, Layer::projection}};
  view_->press("t");
  view_->press("2");  // the slice that this view does not see from its edge
  const Picture start = view_->picture();
  const PixelBox& box = view_->layout().scene;
  for (const auto& [action, layer] : layers) {
    SCOPED_TRACE(text_of(action).word);
    const bool was_visible = view_->views().scene().is_visible(layer);
    view_->press(text_of(action).keys.front());
    EXPECT_NE(view_->views().scene().is_visible(layer), was_visible);
    EXPECT_GT(changed(start, view_->picture(), box), 50);
    click(action);
    EXPECT_EQ(view_->views().scene().is_visible(layer), was_visible);
    EXPECT_EQ(changed(start, view_->picture(), box), 0);
  }
}

TEST_F(ViewWindowTest, OpacitySliderMakesTheLumenOpaqueOverTheBalloon) {
  EXPECT_GT(count_blue(view_->picture(), scene()), 500);
  for (const Layer layer : {Layer::lumen, Layer::wall}) {
    const PixelBox track = view_->controls().opacity_track(layer);
    drag(track.left + int(0.4 * track.width), track.bottom + track.height / 2, track.right() + 9,
         track.bottom + track.height / 2);
    EXPECT_GT(view_->views().scene().opacity(layer), 0.95);
  }
  EXPECT_LT(count_blue(view_->picture(), scene()), 50);
}

TEST_F(ViewWindowTest, FramesAreSteppedThroughAndPressureFollows) {
  EXPECT_EQ(view_->views().frame(), 3u);  // the peak
  EXPECT_NEAR(view_->views().number("pressure_atm"), 8.0, 1e-9);
  const int blue_at_peak = count_blue(view_->picture(), scene());
  click(Action::first_frame);
  EXPECT_EQ(view_->views().frame(), 0u);
  EXPECT_LT(count_blue(view_->picture(), scene()), blue_at_peak / 2);
  view_->press("Right");
  EXPECT_EQ(view_->views().frame(), 1u);
  view_->press("Left");
  view_->press("Left");
  EXPECT_EQ(view_->views().frame(), 0u);
  view_->press("End");
  view_->press("Right");
  EXPECT_EQ(view_->views().frame(), 5u);
}

TEST_F(ViewWindowTest, TimeSliderShowsTheFrameOfItsTime) {
  const PixelBox track = view_->controls().time_track();
  const int y = track.bottom + track.height / 2;
  const double share = view_->views().time_s() / 7.5;
  drag(track.left + int(share * track.width), y, track.left + int(0.3 * track.width), y);
  EXPECT_EQ(view_->views().frame(), 1u);
}

TEST_F(ViewWindowTest, PlaysInRealTimeAndStopsAtTheEndWithoutLoop) {
  view_->press("End");
  view_->press("Left");  // 6.0 s of 7.5 s
  click(Action::loop);
  click(Action::play);
  EXPECT_TRUE(view_->is_playing());
  view_->tick();
  EXPECT_EQ(view_->views().frame(), 4u);
  std::this_thread::sleep_for(std::chrono::milliseconds(1700));
  view_->tick();
  EXPECT_EQ(view_->views().frame(), 5u);
  EXPECT_FALSE(view_->is_playing());
}

TEST_F(ViewWindowTest, LoopBeginsAgain) {
  view_->press("End");
  view_->press("Left");
  view_->press("space");
  std::this_thread::sleep_for(std::chrono::milliseconds(1700));
  view_->tick();
  EXPECT_EQ(view_->views().frame(), 0u);
  EXPECT_TRUE(view_->is_playing());
  view_->press("space");
  EXPECT_FALSE(view_->is_playing());
}

TEST_F(ViewWindowTest, EachFieldOfTheFilesColoursItsBodyWithABar) {
  ASSERT_EQ(view_->views().fields().size(), 1u);
  EXPECT_EQ(view_->views().fields()[0].title(), "wall: contact pressure [kPa]");
  const Picture plain = view_->picture();
  click(Action::next_field);
  const Picture coloured = view_->picture();
  const PixelBox& box = view_->layout().scene;
  const PixelBox bar{box.left + 24, box.bottom + 84, 250, 12};
  EXPECT_GT(changed(plain, coloured, bar), bar.width * bar.height * 9 / 10);
  view_->press("0");
  EXPECT_EQ(changed(plain, view_->picture(), box), 0);
}

TEST_F(ViewWindowTest, CameraTurnsGoesToTreeAndLesionAndFits) {
  vtkCamera* camera = view_->views().scene().renderer()->GetActiveCamera();
  const double at_lesion = camera->GetParallelScale();
  const Picture start = view_->picture();
  const PixelBox box = scene();
  drag(box.left, box.bottom, box.right(), box.top());
  EXPECT_GT(changed(start, view_->picture(), box), 1000);
  click(Action::look_at_tree);
  EXPECT_GT(camera->GetParallelScale(), 1.05 * at_lesion);
  click(Action::look_at_lesion);
  EXPECT_DOUBLE_EQ(camera->GetParallelScale(), at_lesion);
  EXPECT_EQ(changed(start, view_->picture(), box), 0);
  camera->Zoom(40.0);
  event_at(box.left, box.bottom, vtkCommand::MouseMoveEvent);
  view_->press("r");
  EXPECT_GT(camera->GetParallelScale(), at_lesion);
}

TEST_F(ViewWindowTest, SlicesScrollTurnAndGoGrey) {
  const PixelBox box = middle_of(view_->layout().slice);
  const Picture start = view_->picture();
  scroll(box, vtkCommand::MouseWheelForwardEvent);
  for (int i = 0; i < 8; ++i) scroll(box, vtkCommand::MouseWheelForwardEvent);
  EXPECT_GT(changed(start, view_->picture(), view_->layout().slice), 20);
  for (int i = 0; i < 9; ++i) scroll(box, vtkCommand::MouseWheelBackwardEvent);
  EXPECT_EQ(changed(start, view_->picture(), box), 0);
  click(Action::slab);  // the tube bends across the slices
  EXPECT_GT(changed(start, view_->picture(), box), 100);
  view_->press("i");
  click(Action::slice_coronal);
  EXPECT_EQ(view_->views().slice_axis(), SliceAxis::coronal);
  const Picture coronal = view_->picture();
  EXPECT_GT(changed(start, coronal, box), 500);
  drag(box.left, box.bottom, box.left, box.bottom + 100);  // the level falls, all gets brighter
  const auto is_bright = [](int r, int g, int b) { return r > 90 && g > 90 && b > 90; };
  EXPECT_GT(count(view_->picture(), box, is_bright), 2 * count(coronal, box, is_bright));
  click(Action::reset_grey);
  EXPECT_EQ(changed(coronal, view_->picture(), box), 0);
}

TEST_F(ViewWindowTest, SectionWalksWithTheCurveAndTheCursorInTheScene) {
  Views& views = view_->views();
  const double start_mm = views.abscissa_mm();
  const Picture start = view_->picture();
  view_->press("Up");
  EXPECT_NEAR(views.abscissa_mm(), start_mm + 0.5, 1e-9);
  click(Action::walk_back);
  EXPECT_NEAR(views.abscissa_mm(), start_mm, 1e-9);
  const PixelBox& curve = view_->layout().curve;
  click(curve.left + curve.width * 3 / 4, curve.bottom + curve.height / 2);
  EXPECT_GT(views.abscissa_mm(), start_mm + 1.0);
  const Picture further = view_->picture();
  EXPECT_GT(changed(start, further, middle_of(view_->layout().section)), 100);
  EXPECT_GT(changed(start, further, view_->layout().scene), 50);  // the ring
  EXPECT_GT(changed(start, further, curve), 100);
  scroll(view_->layout().section, vtkCommand::MouseWheelBackwardEvent);
  click(Action::walk_to_lesion);
  EXPECT_NEAR(views.abscissa_mm(), start_mm, 1e-9);
}

TEST_F(ViewWindowTest, PickTakesTheCursorToThePlaceUnderThePointer) {
  const PixelBox box = view_->layout().scene;
  // The lesion's view has the vessel along the picture, in its middle.
  const double start_mm = view_->views().abscissa_mm();
  event_at(box.left + box.width * 2 / 3, box.bottom + box.height / 2, vtkCommand::MouseMoveEvent);
  view_->press("p");
  const double right_mm = view_->views().abscissa_mm();
  event_at(box.left + box.width / 3, box.bottom + box.height / 2, vtkCommand::MouseMoveEvent);
  view_->press("p");
  EXPECT_GT(right_mm, view_->views().abscissa_mm() + 1.0);
  EXPECT_NE(right_mm, start_mm);
  event_at(box.left + 2, box.bottom + 2, vtkCommand::MouseMoveEvent);
  view_->press("p");
  EXPECT_THAT(view_->message(), HasSubstr("nothing"));
}

TEST_F(ViewWindowTest, ClipOpensTheWallAndClosesIt) {
  view_->press("l");
  const Picture start = view_->picture();
  const auto is_red = [](int r, int g, int b) { return r > g + 25 && r > b; };
  click(Action::clip);
  const Picture clipped = view_->picture();
  EXPECT_GT(changed(start, clipped, scene()), 500);
  EXPECT_GT(count_blue(clipped, scene()), count_blue(start, scene()));  // the balloon stays whole
  EXPECT_LT(count(clipped, scene(), is_red), count(start, scene(), is_red));
  view_->press("k");
  EXPECT_EQ(changed(start, view_->picture(), scene()), 0);
}

TEST_F(ViewWindowTest, DistanceAndAngleAreThoseOfTheScale) {
  // Half of the section's height is a known length, and its view is parallel.
  const PixelBox box = view_->layout().section;
  const double half_mm = view_->views().section().renderer()->GetActiveCamera()->GetParallelScale();
  const double mm = 2.0 * half_mm / box.height;  // of a pixel
  const int x = box.left + box.width / 2, y = box.bottom + box.height / 2;
  click(Action::measure_distance);
  click(x - 60, y);
  click(x + 60, y);
  click(Action::measure_angle);
  click(x - 50, y);
  click(x, y);
  click(x, y + 50);
  const std::vector<double> values = view_->measures().values();
  ASSERT_EQ(values.size(), 2u);
  EXPECT_NEAR(values[0], 120.0 * mm, 2.0 * mm);
  EXPECT_NEAR(values[1], 90.0, 2.0);
  const Picture measured = view_->picture();
  click(Action::erase_measures);
  EXPECT_TRUE(view_->measures().values().empty());
  EXPECT_GT(changed(measured, view_->picture(), box), 100);
}

TEST_F(ViewWindowTest, DistanceInTheSceneIsBetweenPointsOfTheSurface) {
  const PixelBox box = view_->layout().scene;
  const int y = box.bottom + box.height / 2;
  view_->press("d");
  click(box.left + box.width / 3, y);
  click(box.left + box.width * 2 / 3, y);
  ASSERT_EQ(view_->measures().values().size(), 1u);
  const double mm =
      2.0 * view_->views().scene().renderer()->GetActiveCamera()->GetParallelScale() / box.height;
  EXPECT_GE(view_->measures().values()[0], 0.98 * mm * box.width / 3.0);
  EXPECT_LE(view_->measures().values()[0], 1.5 * mm * box.width / 3.0);
}

TEST_F(ViewWindowTest, WireframeShowsTheMeshAndSurfaceComesBack) {
  const Picture start = view_->picture();
  view_->press("w");
  EXPECT_GT(changed(start, view_->picture(), scene()), 1000);
  click(Action::as_surface);
  EXPECT_EQ(changed(start, view_->picture(), scene()), 0);
}

TEST_F(ViewWindowTest, HelpListsEveryKey) {
  const std::string text = help_text();
  for (const ActionText& action : action_table()) EXPECT_THAT(text, HasSubstr(action.help));
  const Picture start = view_->picture();
  view_->press("question");
  EXPECT_GT(changed(start, view_->picture(), view_->layout().scene), 5000);
  click(Action::help);
  EXPECT_EQ(changed(start, view_->picture(), view_->layout().scene), 0);
}

TEST_F(ViewWindowTest, NoTwoActionsShareAKey) {
  std::vector<std::string> keys;
  for (const ActionText& text : action_table())
    keys.insert(keys.end(), text.keys.begin(), text.keys.end());
  std::sort(keys.begin(), keys.end());
  EXPECT_EQ(std::adjacent_find(keys.begin(), keys.end()), keys.end());
}

TEST_F(ViewWindowTest, PictureAndFilmAreSavedUnderFreeNames) {
  click(Action::save_picture);
  view_->press("F2");
  const Picture saved = angio::test::picture_from_png(read_text(folder_ / "angio_view_002.png"));
  EXPECT_EQ(saved.width, 1200);
  EXPECT_GT(count_blue(saved, scene()), 500);
  EXPECT_THAT(view_->message(), HasSubstr("angio_view_002.png"));
  click(Action::save_film);
  const std::string film = read_text(folder_ / "angio_view_001.ogv");
  EXPECT_THAT(film.substr(0, 64), HasSubstr("OggS"));
  EXPECT_THAT(film.substr(0, 64), HasSubstr("theora"));
  EXPECT_EQ(view_->views().frame(), 3u);  // as before
}

TEST_F(ViewWindowTest, PanelsGoAndTheSceneTakesTheirPlace) {
  view_->press("Tab");
  view_->picture();
  EXPECT_EQ(view_->layout().scene.width, 1200);
  EXPECT_EQ(view_->controls().button_box(Action::play).width, 0);
  view_->press("Tab");
  EXPECT_LT(view_->layout().scene.width, 800);
}

TEST_F(ViewWindowTest, QuitAndSignalsClose) {
  {
    const ClosingSignals signals;
    view_->tick();
    EXPECT_FALSE(view_->is_closing());
    std::raise(SIGTERM);
    view_->tick();
    EXPECT_TRUE(view_->is_closing());
  }
  open();
  click(Action::quit);
  EXPECT_TRUE(view_->is_closing());
}

TEST_F(ViewWindowTest, ARunThatWritesAnotherFrameIsFollowed) {
  view_->press("End");
  const std::filesystem::path simulation = folder_ / "simulation";
  std::vector<formats::TimeStep> steps = formats::read_collection(simulation / "simulation.pvd");
  for (const char* kind : {"balloon", "vessel"}) {
    const std::string file = std::string("frames/") + kind + "_000360.vtp";
    std::filesystem::copy_file(simulation / ("frames/" + std::string(kind) + "_000300.vtp"),
                               simulation / file);
    steps.push_back({9.0, 0, file});
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(600));  // it looks twice a second
  formats::write_collection(simulation / "simulation.pvd", steps);
  view_->tick();
  EXPECT_EQ(view_->views().data().frames.size(), 7u);
  EXPECT_EQ(view_->views().frame(), 6u);  // it showed the last
}

TEST_F(ViewWindowTest, AFirstFrameTurnsUpInAnOpenWindow) {
  std::filesystem::rename(folder_ / "simulation", folder_ / "later");
  open();
  EXPECT_TRUE(view_->views().data().frames.empty());
  std::filesystem::rename(folder_ / "later", folder_ / ".simulation.tmp-1");
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  view_->tick();
  EXPECT_EQ(view_->views().data().frames.size(), 6u);
  EXPECT_GT(count_blue(view_->picture(), view_->layout().scene), 500);
}

TEST(WindowLayout, BoxesFillTheWindowWithoutOverlap) {
  for (const auto& [width, height] :
       {std::pair(1400, 900), std::pair(900, 560), std::pair(3840, 2160)}) {
    const WindowLayout layout = lay_out(width, height, Panels::shown);
    ASSERT_TRUE(layout.has_panels);
    long area = 0;
    for (const PixelBox& box : {layout.scene, layout.controls, layout.player, layout.slice,
                                layout.section, layout.curve}) {
      EXPECT_GT(box.width, 0);
      EXPECT_GT(box.height, 0);
      EXPECT_LE(box.right(), width);
      EXPECT_LE(box.top(), height);
      area += long(box.width) * box.height;
    }
    EXPECT_EQ(area, long(width) * height);
  }
  EXPECT_FALSE(lay_out(600, 400, Panels::shown).has_panels);
  EXPECT_FALSE(lay_out(1400, 900, Panels::hidden).has_panels);
}

}  // namespace
}  // namespace angio::viewer::window
