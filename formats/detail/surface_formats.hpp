#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/units.hpp"
#include "formats/files.hpp"

/// The surface formats other than VTK's own. They are read here rather than by VTK's readers,
/// which take a text file for a mesh, round to float, or trust the counts of a damaged header, or
/// lack them. `name` is the file's, for messages. Points come as stored; the header tells RAS from
/// LPS.
namespace angio::formats::detail {

struct ParsedSurface {
  SurfaceData data;
  bool in_ras = false;  ///< the header said SPACE=RAS
};

/// Refuses a text without a last line break whose last face does not fit those around it: a number
/// that was cut short names another point. A format that counts its faces cannot tell that.
///
/// @param last_face  number of triangles at the mesh's end that are the file's last face
/// @throws InputError naming the file
void require_whole_last_face(std::string_view text, const TriangleMesh& mesh, std::size_t last_face,
                             const std::string& name);

ParsedSurface parse_stl(std::string_view bytes, const std::string& name);  ///< binary or ASCII
ParsedSurface parse_ply(std::string_view bytes, const std::string& name);  ///< all three encodings
ParsedSurface parse_obj(std::string_view bytes, const std::string& name);
ParsedSurface parse_off(std::string_view text, const std::string& name);
/// Of a mesh of solid cells its boundary: so these two.
ParsedSurface parse_gmsh(std::string_view bytes, const std::string& name);  ///< 2.x and 4.1
ParsedSurface parse_medit(std::string_view text, const std::string& name);

/// Binary, float32, header "SPACE=LPS"; normals by the right-hand rule.
std::string stl_bytes(const TriangleMesh& mesh);

/// Binary little-endian, float64, comment "SPACE=LPS".
std::string ply_bytes(const TriangleMesh& mesh);

/// Text with the shortest numbers that read back the same, comment "SPACE=LPS".
std::string obj_text(const TriangleMesh& mesh);

}  // namespace angio::formats::detail
