#include "viewer/window/frame_store.hpp"

#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkGeometryFilter.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyDataNormals.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/files.hpp"
#include "formats/vtk_arrays.hpp"
#include "formats/vtk_grid.hpp"
#include "viewer/detail/plane.hpp"

namespace angio::viewer::window {
namespace fs = std::filesystem;
namespace {

vtkSmartPointer<vtkPolyData> with_normals(vtkPolyData* surface) {
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(surface);
  normals->SplittingOff();
  normals->ConsistencyOff();
  normals->Update();
  return normals->GetOutput();
}

vtkSmartPointer<vtkPolyData> read_triangles(const fs::path& file) {
  const formats::SurfaceData data = formats::read_surface(file);
  const vtkSmartPointer<vtkPolyData> surface = formats::to_vtk(data.mesh);
  formats::add_arrays(surface->GetPointData(), data.point_arrays, data.mesh.vertices.size());
  formats::add_arrays(surface->GetCellData(), data.cell_arrays, data.mesh.triangles.size());
  return surface;
}

vtkSmartPointer<vtkPolyData> read_lines(const fs::path& file) {
  const formats::PolylineData data = formats::read_polylines(file);
  vtkNew<vtkPolyData> lines;
  lines->SetPoints(formats::to_vtk(data.points));
  lines->SetLines(formats::to_vtk_cells(data.lines));
  formats::add_arrays(lines->GetPointData(), data.point_arrays, data.points.size());
  return lines;
}

vtkSmartPointer<vtkPolyData> read_border(const fs::path& file) {
  vtkNew<vtkGeometryFilter> border;
  border->SetInputData(formats::to_vtk(formats::read_wedges(file)));
  border->Update();
  return with_normals(border->GetOutput());
}

TriangleMesh triangles_of(vtkPolyData* surface) {
  TriangleMesh mesh;
  mesh.vertices = formats::from_vtk(surface->GetPoints());
  const auto corners = vtk::TakeSmartPointer(surface->GetPolys()->NewIterator());
  for (corners->GoToFirstCell(); !corners->IsDoneWithTraversal(); corners->GoToNextCell()) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    corners->GetCurrentCell(count, ids);
    if (count == 3) mesh.triangles.push_back({int(ids[0]), int(ids[1]), int(ids[2])});
  }
  return mesh;
}

vtkDataArray* array_of(const FrameShapes& shapes, const Field& field) {
  vtkPolyData* body = shapes.of(field.body);
  if (!body) return nullptr;
  vtkDataSetAttributes* owner = field.is_on_cells
                                    ? static_cast<vtkDataSetAttributes*>(body->GetCellData())
                                    : static_cast<vtkDataSetAttributes*>(body->GetPointData());
  return owner->GetArray(field.array.c_str());
}

/// Of a vector its length.
void add_values(vtkDataArray* array, std::vector<float>& values) {
  const int components = array->GetNumberOfComponents();
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
    double sum = 0.0;
    for (int c = 0; c < components; ++c)
      sum += array->GetComponent(i, c) * array->GetComponent(i, c);
    values.push_back(float(components == 1 ? array->GetComponent(i, 0) : std::sqrt(sum)));
  }
}

}  // namespace

vtkPolyData* FrameShapes::of(Body body) const {
  switch (body) {
    case Body::wall:
      return wall;
    case Body::balloon:
      return balloon;
    case Body::wire:
      return wire;
    case Body::tissue:
      return tissue;
  }
  return nullptr;
}

std::string Field::short_title() const {
  std::string words = array;
  std::replace(words.begin(), words.end(), '_', ' ');
  const char* owner = body == Body::balloon  ? "balloon: "
                      : body == Body::tissue ? "tissue: "
                                             : "wall: ";
  return owner + words;
}

std::string Field::title() const {
  static const std::map<std::string, std::string> kUnits = {
      {"displacement", "mm"},      {"thickness", "mm"},     {"contact_pressure", "kPa"},
      {"principal_stress", "kPa"}, {"axial_stress", "kPa"}, {"circumferential_stress", "kPa"},
      {"von_mises_stress", "kPa"},
  };
  const auto unit = kUnits.find(array);
  return short_title() + (unit == kUnits.end() ? "" : " [" + unit->second + "]");
}

const FrameShapes& FrameStore::at(std::size_t index) {
  const detail::FrameFiles& files = data_.frames.at(index);
  const auto found = shapes_.find(files.frame);
  if (found != shapes_.end()) return found->second;
  FrameShapes shapes;
  shapes.wall = with_normals(read_triangles(files.vessel));
  shapes.balloon = with_normals(read_triangles(files.balloon));
  shapes.wall_mesh = triangles_of(shapes.wall);
  shapes.balloon_mesh = triangles_of(shapes.balloon);
  if (!files.guidewire.empty()) shapes.wire = read_lines(files.guidewire);
  if (!files.tissue.empty()) shapes.tissue = read_border(files.tissue);
  return shapes_.emplace(files.frame, std::move(shapes)).first->second;
}

std::vector<Field> FrameStore::fields() {
  std::vector<Field> fields;
  if (data_.frames.empty()) return fields;
  const FrameShapes& shapes = at(0);
  for (const Body body : {Body::wall, Body::balloon, Body::tissue}) {
    vtkPolyData* surface = shapes.of(body);
    if (!surface) continue;
    const auto add = [&](vtkDataSetAttributes* owner, bool is_on_cells) {
      for (int i = 0; i < owner->GetNumberOfArrays(); ++i) {
        const char* name = owner->GetArrayName(i);
        if (!name || !owner->GetArray(i) || owner->GetArray(i) == owner->GetNormals()) continue;
        fields.push_back({body, name, is_on_cells});
      }
    };
    add(surface->GetPointData(), false);
    add(surface->GetCellData(), true);
  }
  return fields;
}

FieldRange FrameStore::range(const Field& field) {
  std::vector<float> values;
  for (const std::size_t index :
       {std::size_t(0), detail::peak_frame(data_), data_.frames.size() - 1})
    if (vtkDataArray* array = array_of(at(index), field)) add_values(array, values);
  FieldRange range{detail::percentile(values, 0.005), detail::percentile(values, 0.995)};
  if (range.low >= 0.0 && range.low < 0.2 * range.high) range.low = 0.0;
  if (!(range.high > range.low)) range.high = range.low + 1.0;
  return range;
}

}  // namespace angio::viewer::window
