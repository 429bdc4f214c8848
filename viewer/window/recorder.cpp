#include "viewer/window/recorder.hpp"

#include <fmt/format.h>
#include <vtkNew.h>
#include <vtkOggTheoraWriter.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "viewer/detail/rendering.hpp"
#include "viewer/detail/scene.hpp"

namespace angio::viewer::window {
namespace fs = std::filesystem;

detail::Picture grab(vtkRenderWindow* window) {
  window->Render();
  return detail::read_pixels(window);
}

void save_picture(vtkRenderWindow* window, const fs::path& png) {
  write_text_atomically(png, detail::png_bytes(grab(window)));
}

void save_film(vtkRenderWindow* window, const fs::path& ogv, int picture_count,
               int pictures_per_second, const std::function<bool(int)>& draw) {
  write_atomically(ogv, [&](const fs::path& temporary) {
    vtkNew<vtkWindowToImageFilter> grabber;
    grabber->SetInput(window);
    grabber->SetInputBufferTypeToRGB();
    grabber->ReadFrontBufferOff();
    grabber->ShouldRerenderOff();
    vtkNew<vtkOggTheoraWriter> writer;
    writer->SetInputConnection(grabber->GetOutputPort());
    writer->SetFileName(temporary.c_str());
    writer->SetRate(pictures_per_second);
    writer->SetQuality(2);
    for (int picture = 0; picture < picture_count; ++picture) {
      if (draw(picture)) grabber->Modified();
      if (picture == 0) writer->Start();
      writer->Write();
    }
    writer->End();
    if (writer->GetError() != 0)
      throw IoError("cannot write the film " + ogv.string() + ". Is the disk full?");
  });
}

fs::path free_name(const fs::path& folder, const std::string& stem, const std::string& extension) {
  for (int number = 1;; ++number) {
    fs::path path = folder / fmt::format("{}_{:03d}{}", stem, number, extension);
    std::error_code ignored;
    if (!fs::exists(path, ignored)) return path;
  }
}

}  // namespace angio::viewer::window
