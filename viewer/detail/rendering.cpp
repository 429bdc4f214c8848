#include "viewer/detail/rendering.hpp"

#include <vtkNew.h>
#include <vtkPointData.h>
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
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);
  window->SetAlphaBitPlanes(1);
  window->SetNumberOfLayers(int(layers.size()));
  window->SetSize(width * kSupersampling, height * kSupersampling);
  for (vtkRenderer* layer : layers) {
    layer->SetUseDepthPeeling(1);
    layer->SetMaximumNumberOfPeels(12);
    layer->SetOcclusionRatio(0.0);
    window->AddRenderer(layer);
  }
  if (before_drawing) before_drawing();
  window->Render();
  const Picture large = read_pixels(window);
  if (messages.has_error()) throw rendering_failed();
  for (vtkRenderer* layer : layers) window->RemoveRenderer(layer);
  return shrink(large, kSupersampling);
}

}  // namespace angio::viewer::detail
