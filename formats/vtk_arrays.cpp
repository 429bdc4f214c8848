#include "formats/vtk_arrays.hpp"

#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace angio::formats {
namespace {

template <class Array>
vtkSmartPointer<vtkDataArray> make_array(const DataArray& source) {
  using Value = typename Array::ValueType;
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(source.name.c_str());
  array->SetNumberOfComponents(source.component_count);
  array->SetNumberOfValues(vtkIdType(source.values.size()));
  std::transform(source.values.begin(), source.values.end(), array->GetPointer(0),
                 [](double value) { return static_cast<Value>(value); });
  return array;
}

vtkSmartPointer<vtkDataArray> make_typed_array(const DataArray& source) {
  switch (source.type) {
    case ArrayType::float32:
      return make_array<vtkFloatArray>(source);
    case ArrayType::float64:
      return make_array<vtkDoubleArray>(source);
    case ArrayType::int32:
      return make_array<vtkIntArray>(source);
    case ArrayType::uint8:
      return make_array<vtkUnsignedCharArray>(source);
  }
  throw InternalError("array " + source.name + " has no type");
}

/// The type of ours that holds every value of the array.
ArrayType fitting_type(vtkDataArray* array, const std::vector<double>& values) {
  switch (array->GetDataType()) {
    case VTK_FLOAT:
      return ArrayType::float32;
    case VTK_DOUBLE:
      return ArrayType::float64;
    case VTK_UNSIGNED_CHAR:
      return ArrayType::uint8;
    default:
      break;
  }
  const bool fits = std::all_of(values.begin(), values.end(), [](double value) {
    return std::abs(value) <= double(std::numeric_limits<int>::max());
  });
  return fits ? ArrayType::int32 : ArrayType::float64;
}

template <class Cells>
vtkSmartPointer<vtkCellArray> make_cells(const Cells& cells) {
  auto result = vtkSmartPointer<vtkCellArray>::New();
  for (const auto& cell : cells) {
    result->InsertNextCell(int(cell.size()));
    for (const int point : cell) result->InsertCellPoint(point);
  }
  return result;
}

}  // namespace

vtkSmartPointer<vtkPoints> to_vtk(const std::vector<Vec3>& points) {
  auto result = vtkSmartPointer<vtkPoints>::New();
  result->SetDataTypeToDouble();
  result->SetNumberOfPoints(vtkIdType(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i)
    result->SetPoint(vtkIdType(i), points[i].x, points[i].y, points[i].z);
  return result;
}

vtkSmartPointer<vtkCellArray> to_vtk_cells(const std::vector<Triangle>& triangles) {
  return make_cells(triangles);
}
vtkSmartPointer<vtkCellArray> to_vtk_cells(const std::vector<Tet>& tets,
                                           const std::vector<Triangle>& triangles) {
  auto cells = make_cells(tets);
  cells->Append(make_cells(triangles));
  return cells;
}
vtkSmartPointer<vtkCellArray> to_vtk_cells(const std::vector<std::vector<int>>& lines) {
  return make_cells(lines);
}

vtkSmartPointer<vtkPolyData> to_vtk(const TriangleMesh& mesh) {
  auto result = vtkSmartPointer<vtkPolyData>::New();
  result->SetPoints(to_vtk(mesh.vertices));
  result->SetPolys(to_vtk_cells(mesh.triangles));
  return result;
}

void add_arrays(vtkDataSetAttributes* target, const std::vector<DataArray>& arrays,
                std::size_t tuple_count) {
  for (const DataArray& array : arrays) {
    if (array.component_count < 1 ||
        array.values.size() != tuple_count * std::size_t(array.component_count))
      throw InternalError("array " + array.name + " has " + std::to_string(array.values.size()) +
                          " values for " + std::to_string(tuple_count) + " tuples");
    target->AddArray(make_typed_array(array));
  }
}

std::vector<Vec3> from_vtk(vtkPoints* points) {
  std::vector<Vec3> result(points ? std::size_t(points->GetNumberOfPoints()) : 0);
  for (std::size_t i = 0; i < result.size(); ++i) {
    double p[3];
    points->GetPoint(vtkIdType(i), p);
    result[i] = {p[0], p[1], p[2]};
  }
  return result;
}

std::vector<DataArray> from_vtk(vtkDataSetAttributes* source, std::size_t first, std::size_t count,
                                const std::string& name) {
  std::vector<DataArray> result;
  for (int a = 0; a < source->GetNumberOfArrays(); ++a) {
    vtkDataArray* array = source->GetArray(a);
    if (!array || !array->GetName()) continue;
    if (std::size_t(array->GetNumberOfTuples()) < first + count)
      throw InputError(name + ": its array " + array->GetName() +
                       " is too short (the file is damaged). Write it again");
    DataArray copy;
    copy.name = array->GetName();
    copy.component_count = array->GetNumberOfComponents();
    copy.values.reserve(count * std::size_t(copy.component_count));
    for (std::size_t i = first; i < first + count; ++i)
      for (int c = 0; c < copy.component_count; ++c)
        copy.values.push_back(array->GetComponent(vtkIdType(i), c));
    copy.type = fitting_type(array, copy.values);
    result.push_back(std::move(copy));
  }
  return result;
}

}  // namespace angio::formats
