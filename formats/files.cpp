#include "formats/files.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "formats/detail/guarded_files.hpp"
#include "formats/detail/surface_cleanup.hpp"
#include "formats/detail/surface_formats.hpp"
#include "formats/detail/xml_files.hpp"
#include "formats/html.hpp"
#include "formats/text.hpp"
#include "formats/tokens.hpp"

namespace angio::formats {
namespace fs = std::filesystem;
namespace {

/// The value of an XML attribute, with its entities resolved; empty if it is not there.
std::string attribute(std::string_view element, const std::string& name) {
  const std::string key = " " + name + "=\"";
  const auto at = element.find(key);
  if (at == std::string_view::npos) return {};
  const auto begin = at + key.size();
  std::string value(element.substr(begin, element.find('"', begin) - begin));
  for (const auto& [entity, letter] :
       {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&#39;", "'"}, {"&amp;", "&"}})
    for (auto found = value.find(entity); found != std::string::npos;
         found = value.find(entity, found + 1))
      value.replace(found, std::string_view(entity).size(), letter);
  return value;
}

using Parse = detail::ParsedSurface (*)(std::string_view bytes, const std::string& name);

/// What VTK reads, in a guarded child.
constexpr std::array<std::string_view, 5> kOfVtk{".vtp", ".vtk", ".vtu", ".glb", ".gltf"};

bool is_vtks(std::string_view extension) {
  return std::find(kOfVtk.begin(), kOfVtk.end(), extension) != kOfVtk.end();
}

/// How the other files are read.
constexpr std::array<std::pair<std::string_view, Parse>, 6> kParsers{
    {{".stl", detail::parse_stl},
     {".ply", detail::parse_ply},
     {".obj", detail::parse_obj},
     {".off", detail::parse_off},
     {".msh", detail::parse_gmsh},
     {".mesh", detail::parse_medit}}};

detail::ParsedSurface parse_surface(const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (is_vtks(extension)) return detail::read_vtk_surface(path);
  for (const auto& [known, parse] : kParsers)
    if (extension == known) return parse(detail::read_input(path), path.string());
  throw InputError(path.string() + " is of no surface format known here. Give " +
                   surface_endings());
}

/// @param name  of the file
SurfaceData finished(detail::ParsedSurface parsed, const std::string& name) {
  detail::require_usable(parsed.data, name);
  if (parsed.in_ras) detail::swap_ras_lps(parsed.data.mesh.vertices);
  SurfaceData merged = detail::merge_equal_points(std::move(parsed.data));
  detail::require_usable(merged, name);
  return merged;
}

}  // namespace

bool is_surface_ending(std::string_view extension) {
  return is_vtks(extension) ||
         std::any_of(kParsers.begin(), kParsers.end(),
                     [&](const auto& parser) { return parser.first == extension; });
}

std::string surface_endings() {
  std::string endings;
  for (const std::string_view extension : kOfVtk) endings += std::string(extension) + ", ";
  for (const auto& [extension, parse] : kParsers)
    endings += std::string(extension) + (extension == kParsers.back().first ? "" : ", ");
  return endings;
}

const DataArray& find_array(const std::vector<DataArray>& arrays, const std::string& name) {
  const auto found = std::find_if(arrays.begin(), arrays.end(),
                                  [&](const DataArray& array) { return array.name == name; });
  if (found == arrays.end())
    throw InputError("an array named " + name +
                     " is missing (the file comes from another program or version). Run the stage "
                     "that writes it again");
  return *found;
}

void write_surface(const fs::path& path, const SurfaceData& data) {
  const std::string extension = lower_extension(path);
  if (extension == ".vtp")
    write_atomically(path, [&](const fs::path& temporary) { detail::write_vtp(temporary, data); });
  else if (extension == ".stl")
    write_text_atomically(path, detail::stl_bytes(data.mesh));
  else if (extension == ".ply")
    write_text_atomically(path, detail::ply_bytes(data.mesh));
  else if (extension == ".obj")
    write_text_atomically(path, detail::obj_text(data.mesh));
  else
    throw InternalError("no surface writer for " + path.filename().string());
}

void write_polylines(const fs::path& path, const PolylineData& data) {
  write_atomically(path, [&](const fs::path& temporary) { detail::write_vtp(temporary, data); });
}

void write_tets(const fs::path& path, const TetData& data) {
  write_atomically(path, [&](const fs::path& temporary) { detail::write_vtu(temporary, data); });
}

void write_wedges(const fs::path& path, const WedgeData& data) {
  write_atomically(path, [&](const fs::path& temporary) { detail::write_vtu(temporary, data); });
}

SurfaceData read_surface(const fs::path& path) {
  return finished(parse_surface(path), path.string());
}

std::vector<SurfaceData> read_vtp_surfaces(const std::vector<fs::path>& paths) {
  std::vector<SurfaceData> surfaces;
  detail::read_vtp_surfaces(paths, [&](detail::ParsedSurface&& parsed) {
    surfaces.push_back(finished(std::move(parsed), paths[surfaces.size()].string()));
  });
  return surfaces;
}

PolylineData read_polylines(const fs::path& path) {
  return std::move(read_polylines(std::vector{path}).front());
}

std::vector<PolylineData> read_polylines(const std::vector<fs::path>& paths) {
  return detail::read_vtp_polylines(paths);
}

TetData read_tets(const fs::path& path) { return detail::read_vtu_tets(path); }

WedgeData read_wedges(const fs::path& path) { return detail::read_vtu_wedges(path); }

std::vector<TimeStep> read_collection(const fs::path& path) {
  const std::string xml = read_text(path);
  std::vector<TimeStep> steps;
  constexpr std::string_view kElement = "<DataSet";
  for (auto at = xml.find(kElement); at != std::string::npos; at = xml.find(kElement, at + 1)) {
    const auto element = std::string_view(xml).substr(at, xml.find('>', at) - at);
    const auto time = parse_number<double>(attribute(element, "timestep"));
    TimeStep step{time.value_or(0.0), parse_number<int>(attribute(element, "part")).value_or(0),
                  attribute(element, "file")};
    if (step.file.empty() || !time)
      throw InputError(path.string() +
                       " is damaged (a data set has no file or time). Run `angio simulate` again");
    steps.push_back(std::move(step));
  }
  return steps;
}

void write_collection(const fs::path& path, const std::vector<TimeStep>& steps) {
  std::string xml =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "  <Collection>\n";
  for (const TimeStep& step : steps)
    xml += "    <DataSet timestep=\"" + number_text(step.time_s) + "\" part=\"" +
           std::to_string(step.part) + "\" file=\"" + escape_html(step.file) + "\"/>\n";
  xml += "  </Collection>\n</VTKFile>\n";
  write_text_atomically(path, xml);
}

}  // namespace angio::formats
