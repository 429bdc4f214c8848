#pragma once

#include <optional>
#include <string>
#include <vector>

namespace angio::viewer::window {

/// All that a key or a button does. docs and help overlay come from the table of these.
enum class Action {
  play,
  loop,
  step_back,
  step_on,
  first_frame,
  last_frame,
  show_lumen,
  show_wall,
  show_balloon,
  show_wire,
  show_line,
  show_slice,
  show_projection,
  next_field,
  previous_field,
  no_field,
  look_at_lesion,
  look_at_tree,
  reset_camera,
  go_to_pick,
  fly_to_pick,
  walk_back,
  walk_on,
  walk_to_lesion,
  slice_axial,
  slice_coronal,
  slice_sagittal,
  slab,
  reset_grey,
  clip,
  measure_distance,
  measure_angle,
  erase_measures,
  as_wireframe,
  as_surface,
  save_picture,
  save_film,
  toggle_panels,
  help,
  quit,
};

struct ActionText {
  Action action;
  std::string word;               ///< on the button
  std::vector<std::string> keys;  ///< X key symbols
  std::string help;               ///< empty: not in the overlay
};

/// Every action once.
const std::vector<ActionText>& action_table();
const ActionText& text_of(Action action);

/// @param key_symbol  "space", "Right", "h", as X names it; unknown: nothing
std::optional<Action> action_of_key(const std::string& key_symbol);

/// Keys and what they do, a line each.
std::string help_text();

}  // namespace angio::viewer::window
