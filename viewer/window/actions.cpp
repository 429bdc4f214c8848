#include "viewer/window/actions.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace angio::viewer::window {

const std::vector<ActionText>& action_table() {
  static const std::vector<ActionText> kTable = {
      {Action::play, "play", {"space"}, "play or stop"},
      {Action::loop, "loop", {"o"}, "play again and again"},
      {Action::step_back, "<", {"Left"}, "a frame back"},
      {Action::step_on, ">", {"Right"}, "a frame on"},
      {Action::first_frame, "|<", {"Home"}, "first frame"},
      {Action::last_frame, ">|", {"End"}, "last frame"},
      {Action::show_lumen, "lumen", {"l"}, "lumen"},
      {Action::show_wall, "wall", {"v"}, "wall under the balloon"},
      {Action::show_balloon, "balloon", {"n"}, "balloon"},
      {Action::show_wire, "guidewire", {"g"}, "guidewire"},
      {Action::show_line, "centreline", {"c"}, "centreline"},
      {Action::show_slice, "slice in 3D", {"x"}, "the slice in the scene"},
      {Action::show_projection, "MIP in 3D", {"m"}, "maximum projection in the scene"},
      {Action::next_field, ">", {"period"}, "next colour field"},
      {Action::previous_field, "<", {"comma"}, "previous colour field"},
      {Action::no_field, "plain", {"0"}, "plain colours"},
      {Action::look_at_lesion, "lesion", {"b"}, "look at the lesion"},
      {Action::look_at_tree, "tree", {"t"}, "look at the whole tree"},
      {Action::reset_camera, "reset", {"r"}, "fit the view under the pointer"},
      {Action::go_to_pick, "pick", {"p"}, "cursor to the place under the pointer"},
      {Action::fly_to_pick, "fly", {"f"}, "turn about the place under the pointer"},
      {Action::walk_back, "<", {"Down"}, "section towards the inlet"},
      {Action::walk_on, ">", {"Up"}, "section away from the inlet"},
      {Action::walk_to_lesion, "lesion", {"j"}, "section to the lesion"},
      {Action::slice_axial, "axial", {"1"}, "axial slice"},
      {Action::slice_coronal, "coronal", {"2"}, "coronal slice"},
      {Action::slice_sagittal, "sagittal", {"3"}, "sagittal slice"},
      {Action::slab, "MIP", {"i"}, "brightest of 20 mm, not one slice"},
      {Action::reset_grey, "grey", {"u"}, "window and level as at the start"},
      {Action::clip, "clip", {"k"}, "cut lumen and wall open"},
      {Action::measure_distance, "distance", {"d"}, "measure a distance: two clicks"},
      {Action::measure_angle, "angle", {"a"}, "measure an angle: three clicks"},
      {Action::erase_measures, "erase", {"Delete", "BackSpace"}, "erase the measurements"},
      {Action::as_wireframe, "wireframe", {"w"}, "wireframe"},
      {Action::as_surface, "surface", {"s"}, "surface"},
      {Action::save_picture, "picture", {"F2"}, "save a picture (PNG)"},
      {Action::save_film, "film", {"F3"}, "save a film of all frames (OGV)"},
      {Action::toggle_panels, "panels", {"Tab"}, "the scene alone, or all panels"},
      {Action::help, "help", {"h", "question", "F1"}, "this help"},
      {Action::quit, "quit", {"q", "e", "Escape"}, "close"},
  };
  return kTable;
}

const ActionText& text_of(Action action) {
  const auto& table = action_table();
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const ActionText& text) { return text.action == action; });
  ANGIO_EXPECT(found != table.end());
  return *found;
}

std::optional<Action> action_of_key(const std::string& key_symbol) {
  for (const ActionText& text : action_table())
    if (std::find(text.keys.begin(), text.keys.end(), key_symbol) != text.keys.end())
      return text.action;
  return std::nullopt;
}

std::string help_text() {
  std::string text;
  for (const ActionText& action : action_table()) {
    std::string key = action.keys.front();
    if (key == "period") key = ".";
    if (key == "comma") key = ",";
    constexpr std::size_t kKeyWidth = 8;
    text += key + std::string(kKeyWidth - key.size(), ' ') + action.help + "\n";
  }
  return text;
}

}  // namespace angio::viewer::window
