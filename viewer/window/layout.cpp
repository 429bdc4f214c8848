#include "viewer/window/layout.hpp"

#include <algorithm>

namespace angio::viewer::window {

WindowLayout lay_out(int width, int height, Panels panels) {
  constexpr int kLeastWidth = 900, kLeastHeight = 560;
  constexpr int kControls = 196, kPlayer = 62;
  WindowLayout layout;
  layout.scene = {0, 0, width, height};
  layout.has_panels = panels == Panels::shown && width >= kLeastWidth && height >= kLeastHeight;
  if (!layout.has_panels) return layout;
  const int column = std::clamp(width * 29 / 100, 280, 560);
  const int middle = width - kControls - column;
  layout.controls = {0, 0, kControls, height};
  layout.player = {kControls, 0, middle, kPlayer};
  layout.scene = {kControls, kPlayer, middle, height - kPlayer};
  const int curve = height * 28 / 100, section = (height - curve) / 2;
  const int left = width - column;
  layout.curve = {left, 0, column, curve};
  layout.section = {left, curve, column, section};
  layout.slice = {left, curve + section, column, height - curve - section};
  return layout;
}

}  // namespace angio::viewer::window
