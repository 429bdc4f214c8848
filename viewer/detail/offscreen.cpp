#include "viewer/detail/offscreen.hpp"

#include <X11/Xlib.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <sstream>

#include "core/error.hpp"

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

/// The display number that the server writes once it is ready; empty if it never does.
std::string read_display_number(int pipe_end) {
  std::string number;
  pollfd waiting{pipe_end, POLLIN, 0};
  for (;;) {
    const int ready = poll(&waiting, 1, kStartTimeoutMs);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return {};
    char letter = 0;
    const ssize_t count = read(pipe_end, &letter, 1);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return {};
    if (letter == '\n') return number;
    number += letter;
  }
}

/// Becomes the X server; never returns. Only async-signal-safe calls: other threads may live.
[[noreturn]] void become_server(const char* program, int display_pipe) {
  setsid();                          // Ctrl-C in the terminal is for us, not for the server
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // it never outlives us
  const int nowhere = open("/dev/null", O_RDWR);
  dup2(nowhere, STDIN_FILENO);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  constexpr int kPipeInChild = 3;
  if (display_pipe == kPipeInChild)
    fcntl(display_pipe, F_SETFD, 0);
  else
    dup2(display_pipe, kPipeInChild);
  execl(program, "Xvfb", "-displayfd", "3", "-screen", "0", "1280x1024x24", "-nolisten", "tcp",
        "-noreset", static_cast<char*>(nullptr));
  _exit(127);
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

OffscreenDisplay::~OffscreenDisplay() { stop(); }

void OffscreenDisplay::start(const fs::path& xvfb) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    throw Error(ExitCode::unavailable, "cannot start Xvfb (no pipe could be made). Try again");
  const pid_t child = fork();
  if (child == 0) become_server(xvfb.c_str(), ends[1]);
  close(ends[1]);
  const std::string number = child > 0 ? read_display_number(ends[0]) : std::string();
  close(ends[0]);
  server_ = child;
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
  if (server_ <= 0) return;
  kill(server_, SIGTERM);
  while (waitpid(server_, nullptr, 0) < 0 && errno == EINTR) {
  }
  server_ = -1;
  set_variable("DISPLAY", display_before_);
  set_variable(kSoftwareVariable, software_before_);
}

}  // namespace angio::viewer::detail
