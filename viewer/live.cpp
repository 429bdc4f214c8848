#include "viewer/live.hpp"

#include "core/error.hpp"
#include "formats/vtk_messages.hpp"
#include "viewer/detail/case_data.hpp"
#include "viewer/view.hpp"
#include "viewer/window/closing_signals.hpp"
#include "viewer/window/live_window.hpp"

namespace angio::viewer {

LiveRates show_live(const std::filesystem::path& case_folder, const LiveDrive& drive,
                    const LiveOptions& options) {
  const formats::VtkMessages messages;
  detail::check_case(case_folder);
  const DisplayStatus status = display_status();
  if (!status.window)
    throw Error(ExitCode::unavailable, "cannot open a window (" + status.description +
                                           "). Start it where there is a screen");
  for (const std::string& key : options.keys)
    if (!window::LiveWindow::knows_key(key))
      throw Error(ExitCode::usage,
                  "no key of this window is called " + key + ". The window lists them");
  const window::ClosingSignals signals;
  window::LiveWindow live(case_folder, drive, options);
  for (const std::string& key : options.keys) live.press(key);
  return live.run();
}

}  // namespace angio::viewer
