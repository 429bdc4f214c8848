#pragma once

#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <functional>
#include <vector>

#include "viewer/detail/picture.hpp"

/// From a scene to a picture.
namespace angio::viewer::detail {

/// Scenes are drawn this many times larger and shrunk, which smooths edges the same way on every
/// machine (multisampling is up to the driver).
inline constexpr int kSupersampling = 2;

/// What a picture is for. A film's is drawn in a tenth of a still's time: edges are smoothed in the
/// picture as it is (FXAA), and translucent surfaces blend in the order of their actors, which the
/// scene has to get right (nothing is depth-peeled).
enum class PictureFor { still, film };

/// What a window shows, as it was drawn last. @throws Error (69) if it cannot be read back
Picture read_pixels(vtkRenderWindow* window);

/// Draws into memory. An OffscreenDisplay must live.
/// @param width, height  of the result; a still is drawn kSupersampling times larger
/// @param before_drawing  called once the renderers know their size
Picture render_offscreen(const std::vector<vtkRenderer*>& layers, int width, int height,
                         const std::function<void()>& before_drawing = {},
                         PictureFor purpose = PictureFor::still);
/// For an OffscreenDisplay that ends: the window of its pictures.
void close_offscreen_window();

}  // namespace angio::viewer::detail
