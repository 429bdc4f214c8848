#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkStructuredPoints.h>
#include <vtkStructuredPointsReader.h>
#include <vtkXMLImageDataReader.h>

#include <type_traits>

#include "core/error.hpp"
#include "core/frames.hpp"
#include "core/legacy_vtk.hpp"
#include "core/text.hpp"
#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation::detail {
namespace {

/// Remembers that a reader complained, and keeps VTK from printing it.
class ErrorSink : public vtkCommand {
 public:
  static ErrorSink* New() { return new ErrorSink; }
  void Execute(vtkObject*, unsigned long, void*) override { happened = true; }
  bool happened = false;
};

/// The frame named by the field array SPACE; LPS if there is none.
bool is_ras(vtkImageData& image, const std::string& name) {
  auto* space = vtkStringArray::SafeDownCast(image.GetFieldData()->GetAbstractArray("SPACE"));
  if (!space || space->GetNumberOfValues() < 1) return false;
  const std::string frame = space->GetValue(0);
  if (frame != "LPS" && frame != "RAS")
    throw InputError(name + " is in the space \"" + frame +
                     "\" (only LPS and RAS are known). "
                     "Convert it to LPS");
  return frame == "RAS";
}

VolumeGeometry geometry_of(vtkImageData& image, bool ras) {
  VolumeGeometry geometry;
  int extent[6];
  image.GetExtent(extent);
  for (int axis = 0; axis < 3; ++axis) {
    geometry.size[std::size_t(axis)] = extent[2 * axis + 1] - extent[2 * axis] + 1;
    geometry.spacing[axis] = image.GetSpacing()[axis];
    for (int row = 0; row < 3; ++row)
      geometry.direction(row, axis) = image.GetDirectionMatrix()->GetElement(row, axis);
  }
  double first[3];
  image.TransformIndexToPhysicalPoint(extent[0], extent[2], extent[4], first);
  geometry.origin = {first[0], first[1], first[2]};
  if (!ras) return geometry;
  geometry.origin = lps_from_ras(geometry.origin);
  for (int axis = 0; axis < 3; ++axis)
    for (int row = 0; row < 2; ++row) geometry.direction(row, axis) *= -1.0;
  return geometry;
}

/// @throws InputError  unless the reader has read all without a complaint
template <class Reader>
vtkSmartPointer<vtkImageData> read_image(const std::filesystem::path& path,
                                         const std::string& damaged) {
  vtkNew<Reader> reader;
  vtkNew<ErrorSink> errors;
  reader->AddObserver(vtkCommand::ErrorEvent, errors);
  reader->AddObserver(vtkCommand::WarningEvent, errors);
  reader->SetFileName(path.c_str());
  if constexpr (std::is_same_v<Reader, vtkXMLImageDataReader>)
    if (!reader->CanReadFile(path.c_str())) throw InputError(damaged);
  reader->Update();  // the frame lies in the field data, so the whole file is read either way
  if (errors->happened) throw InputError(damaged);
  return reader->GetOutput();
}

/// An image of VTK's legacy format.
vtkSmartPointer<vtkImageData> read_legacy(const std::filesystem::path& path,
                                          const std::string& damaged) {
  const std::string name = path.filename().string(), kind = legacy_vtk_data_set(path);
  if (kind.empty()) throw InputError(damaged);
  if (kind != "STRUCTURED_POINTS")
    throw InputError(name + " holds a VTK data set of the kind " + kind +
                     ", which is no image (STRUCTURED_POINTS). Convert it");
  return read_image<vtkStructuredPointsReader>(path, damaged);
}

}  // namespace

VolumeFile load_vti(const std::filesystem::path& path, VolumePart part) {
  const std::string name = path.filename().string();
  const std::string damaged =
      "cannot read " + name + " (truncated, damaged, or not a VTK image). Copy or export it again";
  const auto data = lower_extension(path) == ".vtk"
                        ? read_legacy(path, damaged)
                        : read_image<vtkXMLImageDataReader>(path, damaged);
  vtkImageData& image = *data;
  vtkDataArray* scalars = image.GetPointData()->GetScalars();
  if (!scalars) scalars = image.GetPointData()->GetArray(0);
  if (!scalars || scalars->GetNumberOfTuples() != image.GetNumberOfPoints())
    throw InputError(damaged);
  if (scalars->GetNumberOfComponents() != 1)
    throw InputError(name +
                     " has several values per voxel (colours or vectors, not intensities). "
                     "Give a volume with one");
  VolumeFile file;
  file.volume.geometry = geometry_of(image, is_ras(image, name));
  if (part == VolumePart::header) return file;
  file.volume.values.resize(std::size_t(scalars->GetNumberOfTuples()));
  for (std::size_t v = 0; v < file.volume.values.size(); ++v)
    file.volume.values[v] = float(scalars->GetComponent(vtkIdType(v), 0));
  return file;
}

}  // namespace angio::segmentation::detail
