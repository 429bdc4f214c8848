#include "formats/detail/outer_surface.hpp"

#include <vtkDataSetSurfaceFilter.h>
#include <vtkFieldData.h>
#include <vtkNew.h>

#include "core/error.hpp"

namespace angio::formats::detail {

vtkSmartPointer<vtkPolyData> outer_surface(vtkDataSet* grid, const std::string& name) {
  vtkNew<vtkDataSetSurfaceFilter> filter;
  filter->SetNonlinearSubdivisionLevel(0);
  filter->SetInputData(grid);
  filter->Update();
  vtkSmartPointer<vtkPolyData> surface = filter->GetOutput();
  if (surface->GetNumberOfPolys() + surface->GetNumberOfStrips() == 0)
    throw InputError(name + " holds a grid without faces. Give a surface or a volume mesh");
  surface->SetFieldData(grid->GetFieldData());  // its frame and unit
  return surface;
}

}  // namespace angio::formats::detail
