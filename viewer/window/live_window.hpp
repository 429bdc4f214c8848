#pragma once

#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "viewer/detail/case_data.hpp"
#include "viewer/detail/picture.hpp"
#include "viewer/live.hpp"
#include "viewer/window/live_solver.hpp"
#include "viewer/window/plain_slider.hpp"
#include "viewer/window/pressure_dial.hpp"
#include "viewer/window/scene_view.hpp"
#include "viewer/window/treated_line.hpp"

namespace angio::viewer::window {

/// The window of a simulation that is driven by hand: the scene, a slider for the pressure, one for
/// the place, the dial. The solver runs beside it; a picture shows the last finished frame.
class LiveWindow {
 public:
  static bool knows_key(const std::string& symbol);

  /// @param drive  lives longer
  LiveWindow(const std::filesystem::path& case_folder, const LiveDrive& drive,
             const LiveOptions& options);
  ~LiveWindow();
  LiveWindow(const LiveWindow&) = delete;
  LiveWindow& operator=(const LiveWindow&) = delete;

  /// Returns when the user closes the window, a signal asks for it, or its time is over.
  LiveRates run();
  /// As a person who presses this key. @param symbol  as X names it
  void press(const std::string& symbol);
  /// As the clock's tick: draws a frame that is new, looks for signals.
  void tick();
  detail::Picture picture();

  [[nodiscard]] const LiveAim& aim() const { return aim_; }
  [[nodiscard]] std::shared_ptr<const LiveState> shown() const { return shown_; }
  [[nodiscard]] bool is_closing() const { return is_closing_; }
  [[nodiscard]] vtkRenderWindowInteractor* interactor() { return interactor_; }
  [[nodiscard]] PixelBox pressure_track() const { return pressure_.track; }
  [[nodiscard]] PixelBox place_track() const { return place_.track; }
  [[nodiscard]] LiveRates rates() const;

 private:
  using Clock = std::chrono::steady_clock;

  void open_window();
  void add_words();
  void lay_out();
  void on_key();
  void on_slider(vtkObject* widget, unsigned long, void*);
  void set_aim(LiveAim aim);
  void show(const LiveState& state);
  void draw();
  void close();

  const LiveDrive& drive_;
  LiveOptions options_;
  detail::CaseData data_;
  TreatedLine line_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkRenderWindowInteractor> interactor_;
  vtkNew<vtkRenderer> front_;
  std::unique_ptr<SceneView> scene_;
  PlainSlider pressure_, place_;
  vtkNew<PressureDial> dial_;
  vtkSmartPointer<vtkTextActor> pressure_words_, place_words_, help_;
  LiveAim aim_;
  std::shared_ptr<const LiveState> shown_;
  int width_ = 0, height_ = 0, picture_count_ = 0;
  bool is_closing_ = false;
  Clock::time_point start_;
  std::unique_ptr<LiveSolver> solver_;  // the last: it ends first
};

}  // namespace angio::viewer::window
