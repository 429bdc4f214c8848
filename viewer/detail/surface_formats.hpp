#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "viewer/files.hpp"

/// The surface formats other than VTK's own. They are read here rather than by VTK's readers,
/// which take a text file for a mesh, round to float, or trust the counts of a damaged header.
/// `name` is the file's, for messages. Points come as stored; the header tells RAS from LPS.
namespace angio::viewer::detail {

struct ParsedSurface {
  SurfaceData data;
  bool in_ras = false;  ///< the header said SPACE=RAS
};

ParsedSurface parse_stl(std::string_view bytes, const std::string& name);  ///< binary or ASCII
ParsedSurface parse_ply(std::string_view bytes, const std::string& name);  ///< all three encodings
ParsedSurface parse_obj(std::string_view bytes, const std::string& name);

/// Binary, float32, header "SPACE=LPS"; normals by the right-hand rule.
std::string stl_bytes(const TriangleMesh& mesh);

/// Binary little-endian, float64, comment "SPACE=LPS".
std::string ply_bytes(const TriangleMesh& mesh);

}  // namespace angio::viewer::detail
