#include "viewer/detail/offscreen.hpp"

#include <X11/Xlib.h>
#include <unistd.h>

#include <cstdlib>
#include <sstream>

#include "core/error.hpp"
#include "viewer/detail/rendering.hpp"

namespace angio::viewer::detail {
namespace fs = std::filesystem;
namespace {

constexpr int kStartTimeoutMs = 30'000;
constexpr const char* kSoftwareVariable = "LIBGL_ALWAYS_SOFTWARE";

std::optional<std::string> get_variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? std::optional<std::string>(value) : std::nullopt;
}

void set_variable(const char* name, const std::optional<std::string>& value) {
  if (value)
    setenv(name, value->c_str(), 1);
  else
    unsetenv(name);
}

}  // namespace

XServerStatus probe_x_server(const std::string& display) {
  XServerStatus status;
  if (display.empty()) return status;
  Display* connection = XOpenDisplay(display.c_str());
  if (!connection) return status;
  int opcode = 0, event = 0, error = 0;
  status.answers = true;
  status.has_gl = XQueryExtension(connection, "GLX", &opcode, &event, &error) == True;
  XCloseDisplay(connection);
  return status;
}

std::optional<fs::path> find_xvfb() {
  std::istringstream folders(get_variable("PATH").value_or("") + ":/usr/bin:/usr/local/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path candidate = fs::path(folder) / "Xvfb";
    if (!folder.empty() && access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return std::nullopt;
}

OffscreenDisplay::OffscreenDisplay()
    : display_before_(get_variable("DISPLAY")), software_before_(get_variable(kSoftwareVariable)) {
  // The private server comes first even where there is a screen, so that pictures do not depend
  // on who is logged in, nor on the graphics card.
  if (const auto xvfb = find_xvfb()) {
    start(*xvfb);
    return;
  }
  const XServerStatus own = probe_x_server(display_before_.value_or(""));
  if (!own.answers || !own.has_gl)
    throw Error(ExitCode::unavailable,
                "cannot render pictures (there is no X display with OpenGL, and Xvfb is not "
                "installed). Install the packages xvfb and libgl1-mesa-dri");
}

OffscreenDisplay::~OffscreenDisplay() {
  close_offscreen_window();
  stop();
}

void OffscreenDisplay::start(const fs::path& xvfb) {
  server_.emplace(ProgramCall{xvfb,
                              {"-displayfd", std::to_string(ChildProgram::kLineFile), "-screen",
                               "0", "1280x1024x24", "-nolisten", "tcp", "-noreset"},
                              {},
                              Session::its_own});
  const std::string number = server_->read_line(kStartTimeoutMs);
  if (number.empty()) {
    stop();
    throw Error(ExitCode::unavailable,
                "cannot render pictures (Xvfb did not start; it needs a writable "
                "/tmp/.X11-unix). Run Xvfb by hand to see why, or set DISPLAY");
  }
  setenv("DISPLAY", (":" + number).c_str(), 1);
  setenv(kSoftwareVariable, "1", 1);
  if (!probe_x_server(":" + number).has_gl) {
    stop();
    throw Error(ExitCode::unavailable,
                "cannot render pictures (Xvfb has no OpenGL here). Install the package "
                "libgl1-mesa-dri");
  }
}

void OffscreenDisplay::stop() noexcept {
  if (!server_) return;
  server_.reset();
  set_variable("DISPLAY", display_before_);
  set_variable(kSoftwareVariable, software_before_);
}

}  // namespace angio::viewer::detail
