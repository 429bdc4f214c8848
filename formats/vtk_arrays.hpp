#pragma once

#include <vtkCellArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <span>
#include <string>
#include <vector>

#include "core/data_array.hpp"
#include "formats/files.hpp"

/// Our plain types as VTK's and back.
namespace angio::formats {

vtkSmartPointer<vtkPoints> to_vtk(const std::vector<Vec3>& points);  ///< float64
vtkSmartPointer<vtkCellArray> to_vtk_cells(const std::vector<Triangle>& triangles);
/// Tetrahedra, then triangles.
vtkSmartPointer<vtkCellArray> to_vtk_cells(const std::vector<Tet>& tets,
                                           const std::vector<Triangle>& triangles);
vtkSmartPointer<vtkCellArray> to_vtk_cells(const std::vector<std::vector<int>>& lines);
vtkSmartPointer<vtkPolyData> to_vtk(const TriangleMesh& mesh);

/// Adds every array, typed as it says. @throws InternalError if a size is not tuple_count's
void add_arrays(vtkDataSetAttributes* target, const std::vector<DataArray>& arrays,
                std::size_t tuple_count);

std::vector<Vec3> from_vtk(vtkPoints* points);

/// The numeric, named arrays; tuples [first, first + count). @throws InputError naming the file if
/// an array is shorter
std::vector<DataArray> from_vtk(vtkDataSetAttributes* source, std::size_t first, std::size_t count,
                                const std::string& name);

}  // namespace angio::formats
