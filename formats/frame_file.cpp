#include "formats/frame_file.hpp"

#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/detail/xml_files.hpp"
#include "formats/vtk_messages.hpp"

namespace angio::formats {
namespace fs = std::filesystem;
namespace {

constexpr const char *kTime = "time_s", *kPressure = "pressure_atm", *kPhase = "phase";

void add_number(vtkFieldData* fields, const char* name, double value) {
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  array->InsertNextValue(value);
  fields->AddArray(array);
}

double number(vtkFieldData* fields, const char* name, const fs::path& path) {
  vtkDataArray* array = fields->GetArray(name);
  if (array == nullptr || array->GetNumberOfValues() != 1)
    throw InputError(path.string() + " has no field data " + name +
                     " (it is no frame of a simulation). Run `angio simulate` again");
  return array->GetTuple1(0);
}

}  // namespace

void write_frame_surface(const fs::path& path, const SurfaceData& data, const FrameMoment& moment) {
  vtkNew<vtkFieldData> fields;
  add_number(fields, kTime, moment.time_s);
  add_number(fields, kPressure, moment.pressure_atm);
  vtkNew<vtkStringArray> phase;
  phase->SetName(kPhase);
  phase->InsertNextValue(moment.phase);
  fields->AddArray(phase);
  write_atomically(path,
                   [&](const fs::path& temporary) { detail::write_vtp(temporary, data, fields); });
}

FrameMoment read_frame_moment(const fs::path& path) {
  const VtkMessages messages;
  vtkNew<vtkXMLPolyDataReader> reader;
  if (!fs::exists(path)) throw InputError("no such file: " + path.string(), ExitCode::no_input);
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkFieldData* fields = reader->GetOutput()->GetFieldData();
  auto* phase = vtkStringArray::SafeDownCast(fields->GetAbstractArray(kPhase));
  return {number(fields, kTime, path), number(fields, kPressure, path),
          phase != nullptr && phase->GetNumberOfValues() > 0 ? std::string(phase->GetValue(0))
                                                             : std::string()};
}

}  // namespace angio::formats
