#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstdlib>
#include <string>

#include "viewer/detail/offscreen.hpp"
#include "viewer/view.hpp"

namespace angio::viewer::detail {
namespace {

std::string display() {
  const char* value = std::getenv("DISPLAY");
  return value ? value : "(unset)";
}

/// No process started by this one lives. Whether a display answers would not tell: its number is
/// free again, and another program may have taken it.
bool no_child_is_left() { return waitpid(-1, nullptr, WNOHANG) < 0 && errno == ECHILD; }

TEST(OffscreenDisplay, AnswersWhileItLivesAndIsGoneAfterwards) {
  if (!find_xvfb()) GTEST_SKIP() << "Xvfb is not installed";
  const std::string before = display();
  std::string inside;
  {
    const OffscreenDisplay offscreen;
    inside = display();
    EXPECT_NE(inside, before);
    EXPECT_TRUE(probe_x_server(inside).answers);
    EXPECT_TRUE(probe_x_server(inside).has_gl);
  }
  EXPECT_EQ(display(), before);
  EXPECT_TRUE(no_child_is_left());
}

TEST(OffscreenDisplay, TwoDoNotShareAServer) {
  if (!find_xvfb()) GTEST_SKIP() << "Xvfb is not installed";
  const OffscreenDisplay outer;
  const std::string first = display();
  {
    const OffscreenDisplay inner;
    EXPECT_NE(display(), first);
  }
  EXPECT_EQ(display(), first);
  EXPECT_TRUE(probe_x_server(first).answers);
}

TEST(OffscreenDisplay, StatusTellsThatPicturesCanBeMade) {
  if (!find_xvfb()) GTEST_SKIP() << "Xvfb is not installed";
  EXPECT_TRUE(display_status().offscreen);
  const OffscreenDisplay offscreen;
  EXPECT_TRUE(display_status().window);
}

TEST(XServer, NoNameIsNoServer) { EXPECT_FALSE(probe_x_server("").answers); }

}  // namespace
}  // namespace angio::viewer::detail
