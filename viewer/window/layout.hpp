#pragma once

/// Where the parts of the window lie. Plain numbers, no renderer.
namespace angio::viewer::window {

/// A rectangle [pixel], counted from the window's lower left corner.
struct PixelBox {
  int left = 0, bottom = 0, width = 0, height = 0;

  [[nodiscard]] int right() const { return left + width; }
  [[nodiscard]] int top() const { return bottom + height; }
  [[nodiscard]] bool contains(int x, int y) const {
    return x >= left && x < right() && y >= bottom && y < top();
  }
};

/// From left to right: controls; the 3D scene over the row that plays; slice, section, curve.
struct WindowLayout {
  PixelBox scene, controls, player, slice, section, curve;
  bool has_panels = false;  ///< where not, the scene fills the window, and the others are empty
};

enum class Panels { shown, hidden };

/// The boxes fill the window and do not overlap. A window under 900 x 560 pixels shows the scene
/// alone.
/// @param width, height  [pixel], > 0
WindowLayout lay_out(int width, int height, Panels panels);

}  // namespace angio::viewer::window
