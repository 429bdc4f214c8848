#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace angio::viewer {

struct ViewOptions {
  int width = 1400;
  int height = 900;
  std::filesystem::path screenshot;  ///< write this picture and return, instead of opening a window
  int frame = -1;                    ///< shown first; -1: the frame of the highest pressure
  std::vector<std::string> keys;     ///< pressed at the start, by X's names: "space", "F2"
  std::filesystem::path save_folder = ".";  ///< where the window's pictures and films go
};

/// Opens the desktop viewer on a case folder: scan, lumen, balloon, wall and a time slider.
/// @throws Error (69) if there is no display, InputError (66) if the case has no results yet
void view_case(const std::filesystem::path& case_folder, const ViewOptions& options);

/// Whether a window can be opened here, and why not.
struct DisplayStatus {
  bool window = false;     ///< $DISPLAY answers
  bool offscreen = false;  ///< pictures can be made ($DISPLAY, or Xvfb is installed)
  std::string description;
};
DisplayStatus display_status();

}  // namespace angio::viewer
