#include "viewer/window/scan_image.hpp"

#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <algorithm>
#include <vector>

#include "viewer/detail/plane.hpp"

namespace angio::viewer::window {
namespace {

/// Every so-manyth voxel is enough to choose black and white.
std::vector<float> thinned(const std::vector<float>& values) {
  constexpr std::size_t kEnough = 500'000;
  const std::size_t stride = 1 + values.size() / kEnough;
  std::vector<float> few;
  for (std::size_t i = 0; i < values.size(); i += stride) few.push_back(values[i]);
  return few;
}

}  // namespace

ScanImage make_scan_image(const Volume<float>& volume) {
  const VolumeGeometry& grid = volume.geometry;
  ScanImage scan;
  scan.image = vtkSmartPointer<vtkImageData>::New();
  scan.image->SetDimensions(grid.size.data());
  scan.image->SetSpacing(grid.spacing.x, grid.spacing.y, grid.spacing.z);
  vtkNew<vtkFloatArray> voxels;
  constexpr int kKeepMemory = 1;
  voxels->SetArray(const_cast<float*>(volume.values.data()), vtkIdType(volume.values.size()),
                   kKeepMemory);
  voxels->SetName("intensity");
  scan.image->GetPointData()->SetScalars(voxels);

  scan.lps_from_image = vtkSmartPointer<vtkMatrix4x4>::New();
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis)
      scan.lps_from_image->SetElement(row, axis, grid.direction(row, axis));
    scan.lps_from_image->SetElement(row, 3, grid.origin[row]);
  }
  const std::vector<float> few = thinned(volume.values);
  scan.black = detail::percentile(few, 0.01);
  scan.white = std::max<double>(detail::percentile(few, 0.9995), scan.black + 1e-3);
  scan.look = vtkSmartPointer<vtkImageProperty>::New();
  scan.look->SetColorWindow(scan.white - scan.black);
  scan.look->SetColorLevel(0.5 * (scan.white + scan.black));
  scan.look->SetInterpolationTypeToLinear();
  scan.voxel_mm = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  return scan;
}

}  // namespace angio::viewer::window
