#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/child_process.hpp"

/// A place to render without a window. Debian's VTK draws through X only, so where nobody sits at
/// a screen, and wherever a picture must have the same bytes as elsewhere, a private X server that
/// draws into memory (Xvfb, with Mesa's software OpenGL) stands in.
namespace angio::viewer::detail {

/// Whether an X server answers there and can do OpenGL.
struct XServerStatus {
  bool answers = false;
  bool has_gl = false;
};
/// @param display  as in $DISPLAY; empty: not there
XServerStatus probe_x_server(const std::string& display);

/// Where Xvfb is installed, searched along $PATH and the usual places.
std::optional<std::filesystem::path> find_xvfb();

/// While it lives, $DISPLAY names an X server that can render: a private Xvfb, or, where Xvfb is
/// missing, the user's own display. The server ends with this object, or with the process. Windows
/// must be gone before it.
class OffscreenDisplay {
 public:
  /// @throws Error (69) naming the package to install if there is neither
  OffscreenDisplay();
  ~OffscreenDisplay();
  OffscreenDisplay(const OffscreenDisplay&) = delete;
  OffscreenDisplay& operator=(const OffscreenDisplay&) = delete;

 private:
  void start(const std::filesystem::path& xvfb);
  void stop() noexcept;

  std::optional<ChildProgram> server_;
  std::optional<std::string> display_before_;
  std::optional<std::string> software_before_;
};

}  // namespace angio::viewer::detail
