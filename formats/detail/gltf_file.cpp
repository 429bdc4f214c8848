#include "formats/detail/gltf_file.hpp"

#include <vtkAppendPolyData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkGLTFReader.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPoints.h>

#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "core/text.hpp"
#include "formats/detail/surface_cleanup.hpp"
#include "formats/vtk_messages.hpp"

namespace angio::formats::detail {
namespace {

/// @param at  begin of a little-endian number of 32 bits
std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t b = 4; b-- > 0;) value = value << 8 | std::uint8_t(bytes[at + b]);
  return value;
}

/// VTK's reader waits for the bytes that a head promises, and packs what it finds there.
/// Source: Khronos, "glTF 2.0 Specification" 2.0.1, 4.4 (GLB: magic, version, length).
void check_file(std::string_view bytes, bool is_binary, const std::string& name) {
  const auto refuse = [&](const char* why) { throw InputError(name + why); };
  if (is_binary) {
    if (bytes.size() < 20 || !bytes.starts_with("glTF"))
      refuse(" is no binary glTF (it does not begin with glTF). Give a .glb of version 2");
    if (number_at(bytes, 4) != 2)
      refuse(" is glTF of another version than 2. Convert it, for example to .stl");
    if (number_at(bytes, 8) != bytes.size())
      refuse(
          " has another length than its head says (cut short, or with something behind it). Copy "
          "or "
          "export it again");
  } else if (bytes.find("\"asset\"") == std::string_view::npos) {
    refuse(" is no glTF (it names no asset). Give a .gltf of version 2");
  }
  for (const char* packed : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"})
    if (bytes.find(packed) != std::string_view::npos)
      refuse(" holds a compressed mesh, which is not read. Export it without compression");
}

}  // namespace

vtkSmartPointer<vtkPolyData> read_gltf_polygons(const std::filesystem::path& path) {
  const std::string name = path.string();
  check_file(read_input(path), lower_extension(path) == ".glb", name);
  const VtkMessages messages;
  vtkNew<vtkGLTFReader> reader;
  reader->SetFileName(path.c_str());
  bool is_damaged = false;
  try {
    reader->Update();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {  // of the library's JSON, and of lengths that it believes
    is_damaged = true;
  }
  if (is_damaged || messages.has_error() || reader->GetOutput() == nullptr)
    throw InputError(name +
                     " cannot be read as glTF (it is damaged, or its bytes lie in another file). "
                     "Export it as .glb");
  vtkNew<vtkAppendPolyData> all;
  const auto block =
      vtkSmartPointer<vtkCompositeDataIterator>::Take(reader->GetOutput()->NewIterator());
  bool any = false;
  for (block->InitTraversal(); !block->IsDoneWithTraversal(); block->GoToNextItem())
    if (auto* poly = vtkPolyData::SafeDownCast(block->GetCurrentDataObject());
        poly != nullptr && poly->GetNumberOfPolys() + poly->GetNumberOfStrips() > 0) {
      vtkNew<vtkPolyData> bare;  // colours and normals differ from mesh to mesh
      bare->SetPoints(poly->GetPoints());
      bare->SetPolys(poly->GetPolys());
      bare->SetStrips(poly->GetStrips());
      all->AddInputData(bare);
      any = true;
    }
  if (!any) throw InputError(name + " holds no triangles (points or lines alone?). Give a surface");
  all->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  all->Update();
  const vtkSmartPointer<vtkPolyData> surface = all->GetOutput();
  vtkPoints& points = *surface->GetPoints();
  for (vtkIdType n = 0; n < points.GetNumberOfPoints(); ++n) {
    double p[3];
    points.GetPoint(n, p);
    points.SetPoint(n, p[0], -p[2], p[1]);
  }
  return surface;
}

}  // namespace angio::formats::detail
