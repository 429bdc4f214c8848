#include "formats/detail/xml_files.hpp"

#include <vtkCellData.h>
#include <vtkErrorCode.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkTriangleFilter.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <optional>

#include "core/error.hpp"
#include "core/text.hpp"
#include "formats/detail/gltf_file.hpp"
#include "formats/detail/header_text.hpp"
#include "formats/detail/legacy_file.hpp"
#include "formats/detail/outer_surface.hpp"
#include "formats/detail/surface_cleanup.hpp"
#include "formats/tokens.hpp"
#include "formats/vtk_arrays.hpp"
#include "formats/vtk_grid.hpp"
#include "formats/vtk_messages.hpp"

namespace angio::formats::detail {
namespace {

constexpr const char* kSpaceArray = "SPACE";

/// More points or cells than this in one file are taken for a damaged header.
constexpr std::uint64_t kMaxCount = 200'000'000;

void tag_space(vtkDataObject* data) {
  vtkNew<vtkStringArray> space;
  space->SetName(kSpaceArray);
  space->InsertNextValue("LPS");
  data->GetFieldData()->AddArray(space);
}

/// A text in the field data; empty if there is none of that name.
std::string field_text(vtkDataObject* data, const char* name) {
  auto* text = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray(name));
  return text && text->GetNumberOfValues() > 0 ? std::string(text->GetValue(0)) : std::string();
}

bool is_tagged_ras(vtkDataObject* data) { return field_text(data, kSpaceArray) == "RAS"; }

/// The unit that the field data name; SPACE means mm, as patient space is in millimetres.
std::optional<LengthUnit> tagged_unit(vtkDataObject* data) {
  for (const char* key : {"UNIT", "Unit", "unit", "UNITS", "Units", "units", "LengthUnit"})
    if (const auto unit = unit_of_name(field_text(data, key))) return unit;
  const std::string space = field_text(data, kSpaceArray);
  return space == "LPS" || space == "RAS" ? std::optional(LengthUnit::mm) : std::nullopt;
}

template <class Writer, class Data>
void write_xml(const std::filesystem::path& path, Data* data) {
  const VtkMessages messages;
  tag_space(data);
  vtkNew<Writer> writer;
  writer->SetFileName(path.c_str());
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToZLib();
  writer->SetIdTypeToInt32();
  if (writer->Write() != 1 || messages.has_error()) {
    const bool is_full = writer->GetErrorCode() == vtkErrorCode::OutOfDiskSpaceError;
    throw IoError("could not write " + path.string() +
                  (is_full ? " (the disk is full). Free some space"
                           : " (VTK's writer failed). Check the folder's permissions and space"));
  }
}

[[noreturn]] void fail_unreadable(const std::string& name) {
  throw InputError(name +
                   " cannot be read as VTK XML (it is damaged, was cut short, or is of "
                   "another kind). Write it again");
}

/// What an attribute says wherever it stands in a text, in either kind of quotes; nothing where it
/// is no count.
std::vector<std::optional<std::uint64_t>> counts_of(std::string_view text, std::string_view key) {
  std::vector<std::optional<std::uint64_t>> counts;
  for (auto at = text.find(key); at != std::string_view::npos; at = text.find(key, at + 1)) {
    const auto equals = text.find_first_not_of(" \t\r\n", at + key.size());
    if (equals == std::string_view::npos || text[equals] != '=') continue;
    const auto quote = text.find_first_not_of(" \t\r\n", equals + 1);
    if (quote == std::string_view::npos) continue;
    const auto end = text.find(text[quote], quote + 1);
    counts.push_back(parse_number<std::uint64_t>(
        text.substr(quote + 1, std::min(end, text.size()) - quote - 1)));
  }
  return counts;
}

/// VTK asks for the memory that a head claims before it has seen the data. A value takes at least a
/// byte, and zlib packs no more than 1032 bytes into one.
///
/// @throws InputError if the file is too short for what it claims
void check_claims(std::string_view bytes, const std::string& name) {
  constexpr std::uint64_t kMostInAByte = 1032, kMostComponents = 1'000'000;
  const auto refuse = [&] {
    throw InputError(name + " claims an absurd size (its header is damaged, or it has over " +
                     std::to_string(kMaxCount) + " elements). Write it again, or decimate it");
  };
  const std::string_view text = bytes.substr(0, bytes.find("<AppendedData"));
  std::uint64_t most = 1;
  for (const std::string_view key :
       {"NumberOfPoints", "NumberOfVerts", "NumberOfLines", "NumberOfStrips", "NumberOfPolys",
        "NumberOfCells", "NumberOfTuples"})
    for (const auto& count : counts_of(text, key)) {
      if (!count || *count > kMaxCount) refuse();
      most = std::max(most, *count);
    }
  std::uint64_t components = 0;
  for (const auto& count : counts_of(text, "NumberOfComponents")) {
    if (!count || *count > kMostComponents) refuse();
    components += *count;
  }
  if (components * most > kMostInAByte * bytes.size()) refuse();
}

/// Looks at the file before VTK does: VTK believes any count that it finds in the head, and takes a
/// file without an end for one with less in it.
void check_file(const std::filesystem::path& path, std::string_view file_type,
                const std::string& name) {
  const std::string bytes = read_input(path);
  const std::string_view head = std::string_view(bytes).substr(0, 65536);
  if (head.find("<VTKFile") == std::string_view::npos)
    throw InputError(name + " is not a VTK XML file (it does not hold <VTKFile>). Give a " +
                     (file_type == "PolyData" ? ".vtp" : ".vtu") + " file");
  if (head.find(file_type) == std::string_view::npos)
    throw InputError(name + " holds another kind of VTK data than " + std::string(file_type) +
                     ". Convert it");
  const std::string_view tail =
      std::string_view(bytes).substr(bytes.size() - std::min<std::size_t>(bytes.size(), 1024));
  if (tail.find("</VTKFile>") == std::string_view::npos)
    throw InputError(name + " ends without </VTKFile> (it was cut short). Copy or write it again");
  check_claims(bytes, name);
}

template <class Reader, class Data>
vtkSmartPointer<Data> read_xml(const std::filesystem::path& path, const char* file_type) {
  const std::string name = path.string();
  check_file(path, file_type, name);
  const VtkMessages messages;
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  try {
    reader->Update();
  } catch (const std::bad_alloc&) {
    fail_unreadable(name);
  }
  vtkSmartPointer<Data> data = reader->GetOutput();
  if (messages.has_error() || reader->GetErrorCode() != vtkErrorCode::NoError || !data)
    fail_unreadable(name);
  return data;
}

/// Every cell's points, checked against the point count.
std::vector<std::vector<int>> read_cells(vtkCellArray* cells, std::size_t point_count,
                                         const std::string& name) {
  std::vector<std::vector<int>> result;
  if (!cells) return result;
  result.reserve(std::size_t(cells->GetNumberOfCells()));
  vtkNew<vtkIdList> ids;
  for (vtkIdType cell = 0; cell < cells->GetNumberOfCells(); ++cell) {
    cells->GetCellAtId(cell, ids);
    std::vector<int> points;
    for (vtkIdType i = 0; i < ids->GetNumberOfIds(); ++i) {
      if (ids->GetId(i) < 0 || std::size_t(ids->GetId(i)) >= point_count) fail_unreadable(name);
      points.push_back(int(ids->GetId(i)));
    }
    result.push_back(std::move(points));
  }
  return result;
}

bool has_triangles_only(vtkPolyData* data) {
  return data->GetNumberOfStrips() == 0 &&
         (data->GetNumberOfPolys() == 0 || data->GetPolys()->IsHomogeneous() == 3);
}

vtkSmartPointer<vtkPolyData> triangulated(vtkPolyData* data) {
  vtkNew<vtkTriangleFilter> filter;
  filter->SetInputData(data);
  filter->PassVertsOff();
  filter->PassLinesOff();
  filter->Update();
  return filter->GetOutput();
}

/// Calls take(cell) for each cell of a grid. @return the points
template <class Take>
std::vector<Vec3> read_grid(const std::filesystem::path& path, const Take& take,
                            std::vector<DataArray>& point_arrays,
                            std::vector<DataArray>& cell_arrays) {
  const std::string name = path.string();
  const auto grid =
      read_xml<vtkXMLUnstructuredGridReader, vtkUnstructuredGrid>(path, "UnstructuredGrid");
  std::vector<Vec3> points = from_vtk(grid->GetPoints());
  require_finite(points, name);
  const auto cells = read_cells(grid->GetCells(), points.size(), name);
  for (const std::vector<int>& cell : cells) take(cell);
  if (is_tagged_ras(grid)) swap_ras_lps(points);
  point_arrays = from_vtk(grid->GetPointData(), 0, points.size(), name);
  cell_arrays = from_vtk(grid->GetCellData(), 0, cells.size(), name);
  return points;
}

/// The boundary of a volume mesh.
vtkSmartPointer<vtkPolyData> read_grid_surface(const std::filesystem::path& path) {
  const auto grid =
      read_xml<vtkXMLUnstructuredGridReader, vtkUnstructuredGrid>(path, "UnstructuredGrid");
  read_cells(grid->GetCells(), std::size_t(grid->GetNumberOfPoints()), path.string());
  return outer_surface(grid, path.string());
}

}  // namespace

void write_vtp(const std::filesystem::path& path, const SurfaceData& data, vtkFieldData* fields) {
  const auto poly = to_vtk(data.mesh);
  for (int i = 0; fields != nullptr && i < fields->GetNumberOfArrays(); ++i)
    poly->GetFieldData()->AddArray(fields->GetAbstractArray(i));
  add_arrays(poly->GetPointData(), data.point_arrays, data.mesh.vertices.size());
  add_arrays(poly->GetCellData(), data.cell_arrays, data.mesh.triangles.size());
  write_xml<vtkXMLPolyDataWriter>(path, poly.Get());
}

void write_vtp(const std::filesystem::path& path, const PolylineData& data) {
  vtkNew<vtkPolyData> poly;
  poly->SetPoints(to_vtk(data.points));
  poly->SetLines(to_vtk_cells(data.lines));
  add_arrays(poly->GetPointData(), data.point_arrays, data.points.size());
  add_arrays(poly->GetCellData(), data.cell_arrays, data.lines.size());
  write_xml<vtkXMLPolyDataWriter>(path, poly.Get());
}

void write_vtu(const std::filesystem::path& path, const TetData& data) {
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(to_vtk(data.mesh.vertices));
  std::vector<int> types(data.mesh.tets.size(), VTK_TETRA);
  types.resize(types.size() + data.boundary.size(), VTK_TRIANGLE);
  grid->SetCells(types.data(), to_vtk_cells(data.mesh.tets, data.boundary));
  add_arrays(grid->GetPointData(), data.point_arrays, data.mesh.vertices.size());
  add_arrays(grid->GetCellData(), data.cell_arrays, types.size());
  write_xml<vtkXMLUnstructuredGridWriter>(path, grid.Get());
}

void write_vtu(const std::filesystem::path& path, const WedgeData& data) {
  write_xml<vtkXMLUnstructuredGridWriter>(path, to_vtk(data).Get());
}

ParsedSurface parse_vtk_surface(const std::filesystem::path& path) {
  const std::string name = path.string();
  const std::string extension = lower_extension(path);
  const bool is_gltf = extension == ".glb" || extension == ".gltf";
  auto poly = is_gltf               ? read_gltf_polygons(path)
              : extension == ".vtk" ? read_legacy_polygons(path)
              : extension == ".vtu" ? read_grid_surface(path)
                                    : read_xml<vtkXMLPolyDataReader, vtkPolyData>(path, "PolyData");
  const auto point_count = std::size_t(poly->GetNumberOfPoints());
  read_cells(poly->GetPolys(), point_count, name);  // checks before a filter relies on them
  read_cells(poly->GetStrips(), point_count, name);
  ParsedSurface result;
  result.in_ras = is_tagged_ras(poly);
  result.data.unit = tagged_unit(poly);
  if (!has_triangles_only(poly)) poly = triangulated(poly);
  result.data.mesh.vertices = from_vtk(poly->GetPoints());
  for (const auto& cell : read_cells(poly->GetPolys(), point_count, name))
    result.data.mesh.triangles.push_back({cell[0], cell[1], cell[2]});
  result.data.point_arrays = from_vtk(poly->GetPointData(), 0, point_count, name);
  // Cell values are in the order vertices, lines, polygons.
  result.data.cell_arrays = from_vtk(
      poly->GetCellData(), std::size_t(poly->GetNumberOfVerts() + poly->GetNumberOfLines()),
      result.data.mesh.triangles.size(), name);
  return result;
}

PolylineData parse_vtp_polylines(const std::filesystem::path& path) {
  const std::string name = path.string();
  const auto poly = read_xml<vtkXMLPolyDataReader, vtkPolyData>(path, "PolyData");
  PolylineData result;
  result.points = from_vtk(poly->GetPoints());
  result.lines = read_cells(poly->GetLines(), result.points.size(), name);
  if (result.lines.empty()) throw InputError(name + " holds no lines. Give a file of centrelines");
  require_finite(result.points, name);
  if (is_tagged_ras(poly)) swap_ras_lps(result.points);
  result.point_arrays = from_vtk(poly->GetPointData(), 0, result.points.size(), name);
  result.cell_arrays = from_vtk(poly->GetCellData(), std::size_t(poly->GetNumberOfVerts()),
                                result.lines.size(), name);
  return result;
}

TetData parse_vtu_tets(const std::filesystem::path& path) {
  const std::string name = path.string();
  TetData result;
  result.mesh.vertices = read_grid(
      path,
      [&](const std::vector<int>& cell) {
        if (cell.size() == 4 && result.boundary.empty())
          result.mesh.tets.push_back({cell[0], cell[1], cell[2], cell[3]});
        else if (cell.size() == 3)
          result.boundary.push_back({cell[0], cell[1], cell[2]});
        else
          throw InputError(name +
                           " holds other cells than tetrahedra and, after them, triangles. Give a "
                           "tetrahedral mesh");
      },
      result.point_arrays, result.cell_arrays);
  return result;
}

WedgeData parse_vtu_wedges(const std::filesystem::path& path) {
  const std::string name = path.string();
  WedgeData result;
  result.points = read_grid(
      path,
      [&](const std::vector<int>& cell) {
        if (cell.size() != 6)
          throw InputError(name + " holds other cells than wedges. Give a mesh of a layered wall");
        result.wedges.push_back(
            turned_wedge({cell[0], cell[1], cell[2], cell[3], cell[4], cell[5]}));
      },
      result.point_arrays, result.cell_arrays);
  return result;
}

}  // namespace angio::formats::detail
