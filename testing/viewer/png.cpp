#include "testing/viewer/png.hpp"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <algorithm>

#include "core/error.hpp"

namespace angio::test {

viewer::detail::Picture picture_from_png(const std::string& bytes) {
  vtkNew<vtkPNGReader> reader;
  reader->SetMemoryBuffer(bytes.data());
  reader->SetMemoryBufferLength(vtkIdType(bytes.size()));
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  const int* size = image->GetDimensions();
  if (reader->GetErrorCode() != 0 || size[0] < 1 || image->GetNumberOfScalarComponents() != 3)
    throw InputError("not a PNG picture");
  viewer::detail::Picture picture = viewer::detail::blank_picture(size[0], size[1]);
  const auto* from = static_cast<const std::uint8_t*>(image->GetScalarPointer());
  const std::size_t row_bytes = std::size_t(size[0]) * 3;
  for (std::size_t row = 0; row < std::size_t(size[1]); ++row)
    std::copy_n(from + (std::size_t(size[1]) - 1 - row) * row_bytes, row_bytes,
                picture.rgb.data() + row * row_bytes);
  return picture;
}

}  // namespace angio::test
