#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>

class vtkDataSet;

namespace angio::formats::detail {

/// The faces that belong to one cell of a grid only: the boundary of a volume mesh, or the cells
/// themselves where they are flat. Cells of higher order are cut at their corners.
///
/// @param name  of the file @throws InputError if there is no face
vtkSmartPointer<vtkPolyData> outer_surface(vtkDataSet* grid, const std::string& name);

}  // namespace angio::formats::detail
