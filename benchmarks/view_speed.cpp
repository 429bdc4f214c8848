// How fast the viewer's window is on this computer: the window that people see, 1400 x 900 pixels,
// drawn by software OpenGL on a private X server, and turned, played and walked along by its own
// keys.
//
//     view_speed CASE [--markdown FILE]

#include <fmt/format.h>
#include <vtkCommand.h>
#include <vtkRenderWindowInteractor.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>

#include "core/error.hpp"
#include "testing/result_table.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/window/view_window.hpp"

namespace {
using angio::viewer::window::ViewWindow;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Of all threads.
double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

/// A row: pictures a second, the longest that one of them took, and their processor time, which a
/// busy computer does not change.
void measure(angio::benchmarks::ResultTable& results, const std::string& what,
             const std::function<void()>& draw) {
  constexpr int kPictures = 40;
  double longest_s = 0.0;
  const double processor_before_s = processor_seconds();
  const Clock::time_point start = Clock::now();
  for (int i = 0; i < kPictures; ++i) {
    const Clock::time_point before = Clock::now();
    draw();
    longest_s = std::max(longest_s, seconds_since(before));
  }
  results.row(
      {what, fmt::format("{:.1f}", kPictures / seconds_since(start)),
       fmt::format("{:.0f}", 1e3 * longest_s),
       fmt::format("{:.0f}", 1e3 * (processor_seconds() - processor_before_s) / kPictures)});
}

}  // namespace

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable results("The viewer's window without a GPU", argc, argv);
  if (argc != 2) {
    fmt::print(stderr, "usage: view_speed CASE [--markdown FILE]\n");
    return EXIT_FAILURE;
  }
  const angio::viewer::detail::OffscreenDisplay display;
  const Clock::time_point start = Clock::now();
  ViewWindow view(argv[1], {}, ViewWindow::Place::on_screen);
  view.press("b");
  results.paragraph(fmt::format("Open after {:.1f} s.", seconds_since(start)));
  results.columns({"what is done", "pictures/s", "longest [ms]", "processor time of one [ms]"});
  const auto& box = view.layout().scene;
  vtkRenderWindowInteractor* mouse = view.interactor();
  int x = box.left + box.width / 2;
  const auto move = [&] {
    mouse->SetEventInformation(++x, box.bottom + box.height / 2);
    mouse->InvokeEvent(vtkCommand::MouseMoveEvent);
  };
  const auto drag = [&](const std::string& what) {
    move();
    mouse->InvokeEvent(vtkCommand::LeftButtonPressEvent);
    measure(results, what, move);
    mouse->InvokeEvent(vtkCommand::LeftButtonReleaseEvent);
  };
  drag("turn the lesion");
  measure(results, "frames, read for the first time", [&] { view.press("Right"); });
  view.press("Home");
  measure(results, "frames again", [&] { view.press("Right"); });
  measure(results, "walk along the line", [&] { view.press("Up"); });
  view.press("t");
  drag("turn the whole tree");
  view.press("m");
  drag("turn the whole tree with the MIP");
  results.write();
  return EXIT_SUCCESS;
} catch (const std::exception& error) {
  fmt::print(stderr, "view_speed: {}\n", error.what());
  return EXIT_FAILURE;
}
