#include "testing/pipeline/wall_probe.hpp"

#include <vtkCellArray.h>
#include <vtkPoints.h>

#include <cmath>

#include "formats/files.hpp"
#include "segmentation/read_volume.hpp"
#include "viewer/level_set_surface.hpp"

namespace angio {

WallProbe::WallProbe(const std::filesystem::path& folder) {
  const std::filesystem::path surface = folder / "segmentation/lumen_surface.vtp";
  if (std::filesystem::exists(surface)) {
    set_surface(formats::read_surface(surface).mesh);
  } else {
    level_set_ = segmentation::read_volume_file(folder / "segmentation/lumen_level_set.nrrd");
    set_surface(viewer::zero_surface(level_set_));
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

}  // namespace angio
