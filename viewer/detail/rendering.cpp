#include "viewer/detail/rendering.hpp"

#include <vtkCameraPass.h>
#include <vtkLightsPass.h>
#include <vtkNew.h>
#include <vtkOpaquePass.h>
#include <vtkOpenGLFXAAPass.h>
#include <vtkOverlayPass.h>
#include <vtkPointData.h>
#include <vtkRenderPassCollection.h>
#include <vtkSequencePass.h>
#include <vtkSmartPointer.h>
#include <vtkTranslucentPass.h>
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

/// Draws translucent surfaces one after the other, in the order of their actors: without passes of
/// its own VTK weights them, whatever their order. Then smooths edges, then adds words.
vtkSmartPointer<vtkRenderPass> make_film_pass() {
  vtkNew<vtkRenderPassCollection> in_space, in_picture;
  in_space->AddItem(vtkNew<vtkLightsPass>());
  in_space->AddItem(vtkNew<vtkOpaquePass>());
  in_space->AddItem(vtkNew<vtkTranslucentPass>());
  vtkNew<vtkSequencePass> scene;
  scene->SetPasses(in_space);
  vtkNew<vtkCameraPass> camera;
  camera->SetDelegatePass(scene);
  vtkNew<vtkOpenGLFXAAPass> smoothing;
  smoothing->SetDelegatePass(camera);
  in_picture->AddItem(smoothing);
  in_picture->AddItem(vtkNew<vtkOverlayPass>());
  auto whole = vtkSmartPointer<vtkSequencePass>::New();
  whole->SetPasses(in_picture);
  return whole;
}

/// Layers in a window for as long as it lives.
class ShownLayers {
 public:
  ShownLayers(vtkRenderWindow* window, const std::vector<vtkRenderer*>& layers, PictureFor purpose)
      : window_(window), layers_(layers) {
    window_->SetNumberOfLayers(int(layers_.size()));
    for (vtkRenderer* layer : layers_) {
      layer->SetUseDepthPeeling(purpose == PictureFor::still);
      layer->SetMaximumNumberOfPeels(12);
      layer->SetOcclusionRatio(0.0);
      if (purpose == PictureFor::film) layer->SetPass(make_film_pass());
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
                         const std::function<void()>& before_drawing, PictureFor purpose) {
  const formats::VtkMessages messages;
  vtkSmartPointer<vtkRenderWindow>& window = offscreen_window();
  if (!window) {
    window = vtkSmartPointer<vtkRenderWindow>::New();
    window->SetOffScreenRendering(1);
    window->SetMultiSamples(0);
    window->SetAlphaBitPlanes(1);
  }
  const int scale = purpose == PictureFor::still ? kSupersampling : 1;
  window->SetSize(width * scale, height * scale);
  const ShownLayers shown(window, layers, purpose);
  if (before_drawing) before_drawing();
  window->Render();
  Picture large = read_pixels(window);
  if (messages.has_error()) throw rendering_failed();
  return scale == 1 ? large : shrink(large, scale);
}

void close_offscreen_window() { offscreen_window() = nullptr; }

}  // namespace angio::viewer::detail
