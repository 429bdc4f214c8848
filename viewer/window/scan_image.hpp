#pragma once

#include <vtkImageData.h>
#include <vtkImageProperty.h>
#include <vtkMatrix4x4.h>
#include <vtkSmartPointer.h>

#include "core/volume.hpp"

namespace angio::viewer::window {

/// The scan as VTK shows it: voxels along the axes, and the matrix that brings them to LPS [mm].
struct ScanImage {
  vtkSmartPointer<vtkImageData> image;
  vtkSmartPointer<vtkMatrix4x4> lps_from_image;
  vtkSmartPointer<vtkImageProperty> look;  ///< window and level, shared by all views of the scan
  double black = 0.0, white = 1.0;         ///< grey levels at the start: 1st and 99.95th percentile
  double voxel_mm = 1.0;                   ///< the shortest edge
};

/// Shows the volume's own memory; it lives longer.
ScanImage make_scan_image(const Volume<float>& volume);

}  // namespace angio::viewer::window
