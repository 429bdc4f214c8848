#include "viewer/window/control_panel.hpp"

#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <utility>

#include "formats/text.hpp"
#include "viewer/window/colors.hpp"

namespace angio::viewer::window {
namespace {

constexpr int kRow = 24, kGap = 4, kMargin = 10;

const std::vector<std::pair<Action, Layer>>& layer_rows() {
  static const std::vector<std::pair<Action, Layer>> kRows = {
      {Action::show_lumen, Layer::lumen},
      {Action::show_wall, Layer::wall},
      {Action::show_balloon, Layer::balloon},
      {Action::show_wire, Layer::wire},
      {Action::show_line, Layer::line},
      {Action::show_slice, Layer::slice},
      {Action::show_projection, Layer::projection},
  };
  return kRows;
}

}  // namespace

ControlPanel::ControlPanel(vtkRenderWindowInteractor* interactor, vtkRenderer* front,
                           ControlEvents events)
    : interactor_(interactor), front_(front), events_(std::move(events)) {
  for (const ActionText& text : action_table()) add_button(text.action);
  for (const auto& [action, layer] : layer_rows()) opacity_[layer] = add_slider();
  time_ = add_slider();
  time_.look->ShowSliderLabelOn();
  time_.look->SetLabelFormat("%.2f s");
  vtkNew<vtkContextActor> actor;
  actor->GetScene()->AddItem(dial_);
  actor->GetScene()->SetRenderer(front_);
  front_->AddActor(actor);
}

void ControlPanel::add_button(Action action) {
  Button button{action, vtkSmartPointer<TextButton>::New(),
                vtkSmartPointer<vtkButtonWidget>::New()};
  button.look->set_word(text_of(action).word);
  button.look->SetRenderer(front_);
  button.widget->SetInteractor(interactor_);
  button.widget->SetDefaultRenderer(front_);
  button.widget->SetCurrentRenderer(front_);
  button.widget->SetRepresentation(button.look);
  button.widget->AddObserver(vtkCommand::StateChangedEvent, this, &ControlPanel::on_button);
  button.widget->On();
  buttons_.push_back(button);
}

PlainSlider ControlPanel::add_slider() {
  PlainSlider slider = make_slider(interactor_, front_);
  slider.widget->AddObserver(vtkCommand::InteractionEvent, this, &ControlPanel::on_slider);
  return slider;
}

void ControlPanel::on_button(vtkObject* widget, unsigned long, void*) {
  for (const Button& button : buttons_)
    if (button.widget == widget) return events_.on_action(button.action);
}

void ControlPanel::on_slider(vtkObject* widget, unsigned long, void*) {
  if (time_.widget == widget) return events_.on_time(time_.look->GetValue());
  for (const auto& [layer, slider] : opacity_)
    if (slider.widget == widget) return events_.on_opacity(layer, slider.look->GetValue());
}

void ControlPanel::place(Action action, const PixelBox& box) {
  for (const Button& button : buttons_)
    if (button.action == action) button.look->place(box);
}

void ControlPanel::place_row(int left, int bottom, int width, const std::vector<Action>& actions) {
  const int count = int(actions.size());
  const int each = (width - (count - 1) * kGap) / count;
  for (int i = 0; i < count; ++i)
    place(actions[std::size_t(i)], {left + i * (each + kGap), bottom, each, kRow});
}

void ControlPanel::place_word(const std::string& word, int left, int bottom) {
  const auto text = detail::make_text(word, 12, colors::kFaintInk);
  text->SetPosition(left, bottom);
  front_->AddActor2D(text);
  words_.push_back(text);
}

void ControlPanel::lay_out(const WindowLayout& layout) {
  for (const Button& button : buttons_) button.look->place({});
  for (auto& [layer, slider] : opacity_) window::place(slider, {}, front_);
  window::place(time_, {}, front_);
  for (const auto& word : words_) front_->RemoveActor2D(word);
  words_.clear();
  dial_->place(0, 0, 0);
  if (!layout.has_panels) return;
  const PixelBox& box = layout.controls;
  constexpr int kDialRadius = 66;
  dial_->place(box.left + 0.5 * box.width, box.top() - kDialRadius - 14.0, kDialRadius);
  const int below = lay_out_layers(box, box.top() - 2 * kDialRadius - 24);
  lay_out_tools(box, below);
  lay_out_player(layout.player);
  const int pair = 2 * 66 + kGap;
  place_row(layout.slice.left + 6, layout.slice.bottom + layout.slice.height - 52, 290,
            {Action::slice_axial, Action::slice_coronal, Action::slice_sagittal, Action::slab,
             Action::reset_grey});
  place_row(layout.section.left + 6, layout.section.top() - 52, pair,
            {Action::walk_back, Action::walk_to_lesion, Action::walk_on});
}

int ControlPanel::lay_out_layers(const PixelBox& box, int top) {
  const int left = box.left + kMargin, width = box.width - 2 * kMargin;
  constexpr int kName = 92;
  int y = top - kRow;
  place_word("shown, and its opacity", left, y + 4);
  for (const auto& [action, layer] : layer_rows()) {
    y -= kRow + kGap;
    place(action, {left, y, kName, kRow});
    window::place(opacity_[layer], {left + kName + 12, y, width - kName - 18, kRow}, front_);
  }
  y -= kRow + kGap;
  place_word("coloured by", left, y + 4);
  y -= kRow + kGap;
  place(Action::previous_field, {left, y, 22, kRow});
  place(Action::no_field, {left + 22 + kGap, y, width - 2 * (22 + kGap), kRow});
  place(Action::next_field, {left + width - 22, y, 22, kRow});
  return y;
}

void ControlPanel::lay_out_tools(const PixelBox& box, int top) {
  const int left = box.left + kMargin, width = box.width - 2 * kMargin;
  int y = top;
  const auto group = [&](const std::string& word, const std::vector<std::vector<Action>>& rows) {
    y -= kRow + kGap;
    place_word(word, left, y + 4);
    for (const auto& row : rows) {
      y -= kRow + kGap;
      place_row(left, y, width, row);
    }
  };
  group("view", {{Action::look_at_lesion, Action::look_at_tree, Action::reset_camera},
                 {Action::as_surface, Action::as_wireframe}});
  group("tools", {{Action::clip, Action::measure_distance},
                  {Action::measure_angle, Action::erase_measures},
                  {Action::save_picture, Action::save_film},
                  {Action::help, Action::toggle_panels, Action::quit}});
}

void ControlPanel::lay_out_player(const PixelBox& box) {
  constexpr int kButtons = 250;
  const int bottom = box.bottom + (box.height - kRow) / 2;
  place_row(box.left + kMargin, bottom, kButtons,
            {Action::first_frame, Action::step_back, Action::play, Action::step_on,
             Action::last_frame, Action::loop});
  window::place(
      time_,
      {box.left + kButtons + 3 * kMargin, box.bottom + 8, box.width - kButtons - 5 * kMargin, kRow},
      front_);
}

void ControlPanel::refresh(const ControlState& state) {
  for (const Button& button : buttons_) button.look->set_on(state.is_on(button.action));
  for (const Button& button : buttons_) {
    if (button.action == Action::play) button.look->set_word(state.is_playing ? "stop" : "play");
    if (button.action == Action::no_field)
      button.look->set_word(state.field.empty() ? "plain" : state.field);
  }
  for (auto& [layer, slider] : opacity_) slider.look->SetValue(state.opacity(layer));
  time_.look->SetMinimumValue(state.first_time_s);
  time_.look->SetMaximumValue(std::max(state.last_time_s, state.first_time_s + 1e-9));
  time_.look->SetValue(state.time_s);
  dial_->set_highest(state.highest_atm);
  dial_->show(state.pressure_atm, state.phase);
}

PixelBox ControlPanel::button_box(Action action) const {
  for (const Button& button : buttons_)
    if (button.action == action) return button.look->box();
  return {};
}

PixelBox ControlPanel::opacity_track(Layer layer) const { return opacity_.at(layer).track; }

}  // namespace angio::viewer::window
