#pragma once

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <array>

#include "formats/files.hpp"

namespace angio::formats {

/// Wedges with their arrays as VTK's.
vtkSmartPointer<vtkUnstructuredGrid> to_vtk(const WedgeData& data);

/// From our order of a wedge's corners to VTK's, or back: there the first triangle's normal points
/// out of the wedge.
std::array<int, 6> turned_wedge(const std::array<int, 6>& wedge);

}  // namespace angio::formats
