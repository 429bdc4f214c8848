#include "benchmarks/wall_probe.hpp"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <cmath>

#include "segmentation/read_volume.hpp"
#include "viewer/files.hpp"

namespace angio {

WallProbe::WallProbe(const std::filesystem::path& folder) {
  const std::filesystem::path surface = folder / "segmentation/lumen_surface.vtp";
  if (std::filesystem::exists(surface)) {
    set_surface(viewer::read_surface(surface).mesh);
  } else {
    level_set_ = segmentation::read_volume_file(folder / "segmentation/lumen_level_set.nrrd");
    set_surface(contour());
  }
}

double WallProbe::to_wall(const Vec3& point) const { return std::abs(signed_distance(point)); }

bool WallProbe::is_inside(const Vec3& point) const {
  return level_set_.values.empty() ? signed_distance(point) < 0.0
                                   : interpolate(level_set_, point) < 0.0;
}

double WallProbe::signed_distance(const Vec3& point) const {
  double x[3] = {point.x, point.y, point.z};
  return distance_->EvaluateFunction(x);
}

void WallProbe::set_surface(const TriangleMesh& mesh) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& v : mesh.vertices) points->InsertNextPoint(v.x, v.y, v.z);
  vtkNew<vtkCellArray> cells;
  for (const Triangle& t : mesh.triangles) {
    const vtkIdType corners[3] = {t[0], t[1], t[2]};
    cells->InsertNextCell(3, corners);
  }
  vtkNew<vtkPolyData> wall;
  wall->SetPoints(points);
  wall->SetPolys(cells);
  distance_->SetInput(wall);
}

TriangleMesh WallProbe::contour() {
  const VolumeGeometry& grid = level_set_.geometry;
  vtkNew<vtkImageData> image;  // in voxels; its points are taken to LPS below
  image->SetDimensions(grid.size.data());
  vtkNew<vtkFloatArray> values;
  values->SetArray(level_set_.values.data(), vtkIdType(level_set_.values.size()), 1);
  image->GetPointData()->SetScalars(values);
  vtkNew<vtkFlyingEdges3D> zero;
  zero->SetInputData(image);
  zero->SetValue(0, 0.0);
  zero->ComputeNormalsOff();
  zero->ComputeGradientsOff();
  zero->Update();
  TriangleMesh mesh;
  vtkPolyData& found = *zero->GetOutput();
  for (vtkIdType p = 0; p < found.GetNumberOfPoints(); ++p) {
    double x[3];
    found.GetPoint(p, x);
    mesh.vertices.push_back(grid.lps_from_index({x[0], x[1], x[2]}));
  }
  vtkNew<vtkIdList> corners;
  for (vtkIdType c = 0; c < found.GetNumberOfCells(); ++c) {
    found.GetCellPoints(c, corners);
    mesh.triangles.push_back(
        {int(corners->GetId(0)), int(corners->GetId(1)), int(corners->GetId(2))});
  }
  return mesh;
}

}  // namespace angio
