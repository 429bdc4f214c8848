#include "viewer/level_set_surface.hpp"

#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include "formats/vtk_arrays.hpp"

namespace angio::viewer {

TriangleMesh zero_surface(const Volume<float>& level_set) {
  const VolumeGeometry& grid = level_set.geometry;
  vtkNew<vtkImageData> image;  // in voxels; its points are taken to LPS below
  image->SetDimensions(grid.size.data());
  vtkNew<vtkFloatArray> values;
  constexpr int kKeep = 1;  // the array stays ours, and is only read
  values->SetArray(const_cast<float*>(level_set.values.data()), vtkIdType(level_set.values.size()),
                   kKeep);
  image->GetPointData()->SetScalars(values);
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(image);
  contour->SetValue(0, 0.0);
  contour->ComputeNormalsOff();
  contour->ComputeGradientsOff();
  contour->Update();
  TriangleMesh mesh;
  vtkPolyData& found = *contour->GetOutput();
  mesh.vertices = formats::from_vtk(found.GetPoints());
  for (Vec3& vertex : mesh.vertices) vertex = grid.lps_from_index(vertex);
  vtkNew<vtkIdList> corners;
  for (vtkIdType c = 0; c < found.GetNumberOfCells(); ++c) {
    found.GetCellPoints(c, corners);
    // VTK's triangles face lower values, and those are inside.
    mesh.triangles.push_back(
        {int(corners->GetId(0)), int(corners->GetId(2)), int(corners->GetId(1))});
  }
  return mesh;
}

}  // namespace angio::viewer
