#pragma once

#include <vtkImplicitPlaneRepresentation.h>
#include <vtkImplicitPlaneWidget2.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkTextActor.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "viewer/detail/picture.hpp"
#include "viewer/view.hpp"
#include "viewer/window/actions.hpp"
#include "viewer/window/control_panel.hpp"
#include "viewer/window/layout.hpp"
#include "viewer/window/measures.hpp"
#include "viewer/window/mouse_style.hpp"
#include "viewer/window/run_watch.hpp"
#include "viewer/window/views.hpp"

namespace angio::viewer::window {

/// The desktop viewer's window. Keys, buttons and mouse all come as events of the interactor, so a
/// test that posts them there does what a person does.
class ViewWindow {
 public:
  enum class Place { on_screen, off_screen };

  /// @throws InputError (66) if the case has no results yet
  ViewWindow(const std::filesystem::path& case_folder, const ViewOptions& options, Place place);
  ~ViewWindow();
  ViewWindow(const ViewWindow&) = delete;
  ViewWindow& operator=(const ViewWindow&) = delete;

  /// Returns when the user closes the window, or a signal asks for it (ClosingSignals).
  void run();
  /// What a key or a button does.
  void perform(Action action);
  /// As a person who presses this key. @param symbol  as X names it: "space", "h"
  void press(const std::string& symbol);
  /// As the clock's tick: plays, follows the run, looks for signals.
  void tick();
  /// Draws the window. @return what it shows
  detail::Picture picture();
  void save(const std::filesystem::path& png);

  [[nodiscard]] vtkRenderWindowInteractor* interactor() { return interactor_; }
  [[nodiscard]] const ControlPanel& controls() const { return *controls_; }
  [[nodiscard]] const WindowLayout& layout() const { return layout_; }
  [[nodiscard]] const Measures& measures() const { return *measures_; }
  [[nodiscard]] Views& views() { return *views_; }
  [[nodiscard]] bool is_playing() const { return is_playing_; }
  [[nodiscard]] bool is_closing() const { return is_closing_; }
  [[nodiscard]] const std::string& message() const { return message_; }

 private:
  using Clock = std::chrono::steady_clock;

  void open_case();
  void close_case();
  void add_views();
  void add_mouse();
  void lay_out();
  void update();  ///< controls and words as the state is; then draws
  void on_draw();
  void on_key();
  void on_clip();

  bool perform_player(Action action);
  bool perform_layer(Action action);
  bool perform_camera(Action action);
  bool perform_slices(Action action);
  bool perform_tool(Action action);
  [[nodiscard]] bool is_on(Action action) const;
  void show(std::size_t frame);
  void show_time(double time_s);
  void play_on();
  void follow_run();
  void choose_field(int step);
  void clip(bool is_clipped);
  void pick(Action action);
  void film();
  void say(const std::string& message);
  [[nodiscard]] vtkRenderer* view_at(int x, int y) const;
  [[nodiscard]] double scene_aspect() const;

  std::filesystem::path folder_;
  ViewOptions options_;
  RunWatch watch_;
  vtkNew<vtkRenderWindow> window_;
  vtkSmartPointer<vtkRenderWindowInteractor> interactor_;
  vtkNew<vtkRenderer> ground_, front_;
  vtkSmartPointer<vtkRenderer> axes_;
  vtkNew<MouseStyle> mouse_;
  vtkSmartPointer<vtkTextActor> help_;
  std::unique_ptr<Views> views_;
  std::unique_ptr<ControlPanel> controls_;
  std::unique_ptr<Measures> measures_;
  vtkNew<vtkImplicitPlaneRepresentation> clip_look_;
  vtkNew<vtkImplicitPlaneWidget2> clip_widget_;
  vtkNew<vtkPlane> clip_plane_;
  WindowLayout layout_;
  Panels panels_ = Panels::shown;
  int width_ = 0, height_ = 0;
  bool is_playing_ = false, loops_ = true, is_clipped_ = false, is_wireframe_ = false;
  bool is_closing_ = false;
  double play_from_s_ = 0.0;
  Clock::time_point play_start_, last_look_, message_end_;
  std::string message_;
};

}  // namespace angio::viewer::window
