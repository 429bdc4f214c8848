#include "viewer/view.hpp"

#include <cstdlib>

#include "core/error.hpp"
#include "formats/vtk_messages.hpp"
#include "viewer/detail/case_data.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/window/actions.hpp"
#include "viewer/window/closing_signals.hpp"
#include "viewer/window/view_window.hpp"

namespace angio::viewer {
namespace fs = std::filesystem;
namespace {

std::string display_name() {
  const char* display = std::getenv("DISPLAY");
  return display ? display : "";
}

void check_keys(const std::vector<std::string>& keys) {
  for (const std::string& key : keys) {
    if (window::action_of_key(key)) continue;
    std::string known;
    for (const window::ActionText& action : window::action_table())
      known += (known.empty() ? "" : " ") + action.keys.front();
    throw Error(ExitCode::usage, "no key of the viewer is called " + key + ". There are: " + known);
  }
}

void press_keys(window::ViewWindow& view, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) view.press(key);
}

void write_screenshot(const fs::path& case_folder, const ViewOptions& options) {
  const detail::OffscreenDisplay display;
  window::ViewWindow view(case_folder, options, window::ViewWindow::Place::off_screen);
  press_keys(view, options.keys);
  view.save(options.screenshot);
}

}  // namespace

void view_case(const fs::path& case_folder, const ViewOptions& options) {
  check_keys(options.keys);
  const formats::VtkMessages messages;
  if (!options.screenshot.empty()) return write_screenshot(case_folder, options);
  detail::check_case(case_folder);
  const DisplayStatus status = display_status();
  if (!status.window)
    throw Error(ExitCode::unavailable,
                "cannot open a window (" + status.description +
                    "). Use --screenshot FILE.png, or open report/index.html");
  const window::ClosingSignals signals;
  window::ViewWindow view(case_folder, options, window::ViewWindow::Place::on_screen);
  press_keys(view, options.keys);
  if (!view.is_closing()) view.run();
}

DisplayStatus display_status() {
  DisplayStatus status;
  const std::string name = display_name();
  const detail::XServerStatus server = detail::probe_x_server(name);
  const auto xvfb = detail::find_xvfb();
  status.window = server.answers && server.has_gl;
  status.offscreen = status.window || xvfb.has_value();
  if (status.window)
    status.description = "display " + name + " with OpenGL";
  else if (server.answers)
    status.description = "display " + name + " answers but has no OpenGL (install libgl1-mesa-dri)";
  else if (name.empty())
    status.description = "no display: $DISPLAY is not set";
  else
    status.description = "no display: " + name + " does not answer";
  status.description +=
      xvfb ? "; pictures are rendered by Xvfb" : "; Xvfb is not installed (package xvfb)";
  return status;
}

}  // namespace angio::viewer
