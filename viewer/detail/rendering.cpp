#include "viewer/detail/rendering.hpp"

#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>

#include "core/error.hpp"
#include "formats/vtk_messages.hpp"

namespace angio::viewer::detail {
namespace {

Error rendering_failed() {
  return {ExitCode::unavailable,
          "cannot render pictures (OpenGL failed on this display). Install the packages "
          "xvfb and libgl1-mesa-dri"};
}

/// One window draws all pictures on a display: each new one would compile its shaders again.
vtkSmartPointer<vtkRenderWindow>& offscreen_window() {
  static vtkSmartPointer<vtkRenderWindow> window;
  return window;
}

/// Layers in a window for as long as it lives.
class ShownLayers {
 public:
  ShownLayers(vtkRenderWindow* window, const std::vector<vtkRenderer*>& layers)
      : window_(window), layers_(layers) {
    window_->SetNumberOfLayers(int(layers_.size()));
    for (vtkRenderer* layer : layers_) {
      layer->SetUseDepthPeeling(1);
      layer->SetMaximumNumberOfPeels(12);
      layer->SetOcclusionRatio(0.0);
      window_->AddRenderer(layer);
    }
  }
  ~ShownLayers() {
    for (vtkRenderer* layer : layers_) window_->RemoveRenderer(layer);
  }
  ShownLayers(const ShownLayers&) = delete;
  ShownLayers& operator=(const ShownLayers&) = delete;

 private:
  vtkRenderWindow* window_;
  const std::vector<vtkRenderer*>& layers_;
};

}  // namespace

Picture read_pixels(vtkRenderWindow* window) {
  vtkNew<vtkWindowToImageFilter> grabber;
  grabber->SetInput(window);
  grabber->SetInputBufferTypeToRGB();
  grabber->ReadFrontBufferOff();
  grabber->ShouldRerenderOff();
  grabber->Update();
  auto* pixels =
      vtkUnsignedCharArray::SafeDownCast(grabber->GetOutput()->GetPointData()->GetScalars());
  if (!pixels) throw rendering_failed();
  const int* size = grabber->GetOutput()->GetDimensions();
  Picture picture{size[0], size[1], {}};
  const std::size_t row_bytes = std::size_t(picture.width) * 3;
  picture.rgb.resize(row_bytes * std::size_t(picture.height));
  const unsigned char* source = pixels->GetPointer(0);
  for (std::size_t row = 0; row < std::size_t(picture.height); ++row)  // VTK counts from the bottom
    std::copy_n(source + row * row_bytes, row_bytes,
                picture.rgb.data() + (std::size_t(picture.height) - 1 - row) * row_bytes);
  return picture;
}

Picture render_offscreen(const std::vector<vtkRenderer*>& layers, int width, int height,
                         const std::function<void()>& before_drawing) {
  const formats::VtkMessages messages;
  vtkSmartPointer<vtkRenderWindow>& window = offscreen_window();
  if (!window) {
    window = vtkSmartPointer<vtkRenderWindow>::New();
    window->SetOffScreenRendering(1);
    window->SetMultiSamples(0);
    window->SetAlphaBitPlanes(1);
  }
  window->SetSize(width * kSupersampling, height * kSupersampling);
  const ShownLayers shown(window, layers);
  if (before_drawing) before_drawing();
  window->Render();
  const Picture large = read_pixels(window);
  if (messages.has_error()) throw rendering_failed();
  return shrink(large, kSupersampling);
}

void close_offscreen_window() { offscreen_window() = nullptr; }

}  // namespace angio::viewer::detail
