#include <gtest/gtest.h>

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
  EXPECT_FALSE(probe_x_server(inside).answers);
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
