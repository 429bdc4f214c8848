#pragma once

#include <vtkSmartPointer.h>
#include <vtkVolume.h>

#include "viewer/window/scan_image.hpp"

namespace angio::viewer::window {

/// The scan's maximum intensity projection, in the scene's view. It is cast on the processor, from
/// voxels thinned to at most 160 along each axis; grey levels run as at the start.
vtkSmartPointer<vtkVolume> make_projection_volume(const ScanImage& scan);

/// @param opacity  of what is white, [0, 1]
void set_projection_opacity(vtkVolume* projection, double opacity);

}  // namespace angio::viewer::window
