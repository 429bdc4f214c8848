#include "formats/vtk_grid.hpp"

#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <vector>

#include "formats/vtk_arrays.hpp"

namespace angio::formats {

std::array<int, 6> turned_wedge(const std::array<int, 6>& wedge) {
  return {wedge[0], wedge[2], wedge[1], wedge[3], wedge[5], wedge[4]};
}

vtkSmartPointer<vtkUnstructuredGrid> to_vtk(const WedgeData& data) {
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(to_vtk(data.points));
  std::vector<std::vector<int>> cells;
  cells.reserve(data.wedges.size());
  for (const auto& wedge : data.wedges) {
    const auto corners = turned_wedge(wedge);
    cells.emplace_back(corners.begin(), corners.end());
  }
  grid->SetCells(VTK_WEDGE, to_vtk_cells(cells));
  add_arrays(grid->GetPointData(), data.point_arrays, data.points.size());
  add_arrays(grid->GetCellData(), data.cell_arrays, data.wedges.size());
  return grid;
}

}  // namespace angio::formats
