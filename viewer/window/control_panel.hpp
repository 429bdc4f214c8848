#pragma once

#include <vtkButtonWidget.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "viewer/window/actions.hpp"
#include "viewer/window/layout.hpp"
#include "viewer/window/plain_slider.hpp"
#include "viewer/window/pressure_dial.hpp"
#include "viewer/window/scene_view.hpp"
#include "viewer/window/text_button.hpp"

namespace angio::viewer::window {

/// What the controls show.
struct ControlState {
  std::function<bool(Action)> is_on;
  std::function<double(Layer)> opacity;
  std::string field;  ///< the one coloured by
  bool is_playing = false;
  double time_s = 0.0, first_time_s = 0.0, last_time_s = 0.0;
  double pressure_atm = 0.0, highest_atm = 0.0;
  std::string phase;
};

/// What they do.
struct ControlEvents {
  std::function<void(Action)> on_action;
  std::function<void(Layer, double)> on_opacity;
  std::function<void(double time_s)> on_time;
};

/// Buttons, sliders and the dial, on a renderer over the whole window.
class ControlPanel {
 public:
  ControlPanel(vtkRenderWindowInteractor* interactor, vtkRenderer* front, ControlEvents events);

  void lay_out(const WindowLayout& layout);
  void refresh(const ControlState& state);
  /// Where a button lies; empty while it is hidden.
  [[nodiscard]] PixelBox button_box(Action action) const;
  /// Where a slider's knob runs, from 0 to 1.
  [[nodiscard]] PixelBox opacity_track(Layer layer) const;
  [[nodiscard]] PixelBox time_track() const { return time_.track; }

 private:
  struct Button {
    Action action;
    vtkSmartPointer<TextButton> look;
    vtkSmartPointer<vtkButtonWidget> widget;
  };
  void add_button(Action action);
  PlainSlider add_slider();
  void place(Action action, const PixelBox& box);
  void place_row(int left, int bottom, int width, const std::vector<Action>& actions);
  void place_word(const std::string& word, int left, int bottom);
  int lay_out_layers(const PixelBox& box, int top);
  void lay_out_tools(const PixelBox& box, int top);
  void lay_out_player(const PixelBox& box);
  void on_button(vtkObject* widget, unsigned long, void*);
  void on_slider(vtkObject* widget, unsigned long, void*);

  vtkRenderWindowInteractor* interactor_;
  vtkRenderer* front_;
  ControlEvents events_;
  std::vector<Button> buttons_;
  std::map<Layer, PlainSlider> opacity_;
  PlainSlider time_;
  vtkNew<PressureDial> dial_;
  std::vector<vtkSmartPointer<vtkTextActor>> words_;
};

}  // namespace angio::viewer::window
