#include <limits>

#include "core/error.hpp"
#include "viewer/detail/surface_cleanup.hpp"
#include "viewer/detail/surface_formats.hpp"
#include "viewer/detail/tokens.hpp"

namespace angio::viewer::detail {
namespace {

[[noreturn]] void fail(const std::string& name, int line, const char* what) {
  throw InputError(name + " line " + std::to_string(line) + " " + what +
                   " (the file is damaged or not an OBJ surface). Export the surface again");
}

/// "7", "7/1", "7//2" or "-1": a point counted from 1, or from the last one backwards.
int parse_corner(std::string_view word, std::size_t vertex_count, const std::string& name,
                 int line) {
  const auto number = parse_number<long>(word.substr(0, word.find('/')));
  if (!number || *number == 0) fail(name, line, "has a face that is not a list of points");
  const long index = *number > 0 ? *number - 1 : long(vertex_count) + *number;
  if (index < 0 || index >= long(vertex_count)) fail(name, line, "names a point that is not there");
  return int(index);
}

}  // namespace

ParsedSurface parse_obj(std::string_view bytes, const std::string& name) {
  ParsedSurface result;
  TriangleMesh& mesh = result.data.mesh;
  Lines lines(bytes);
  int line_number = 0;
  while (const auto line = lines.next()) {
    ++line_number;
    Tokens tokens(*line);
    const std::string_view kind = tokens.next();
    if (kind.starts_with('#') && says_ras(*line)) result.in_ras = true;
    if (kind == "v") {
      Vec3 point;
      for (int axis = 0; axis < 3; ++axis) {
        const auto number = parse_number<double>(tokens.next());
        if (!number) fail(name, line_number, "has a point that is not three numbers");
        point[axis] = *number;
      }
      mesh.vertices.push_back(point);
    } else if (kind == "f") {
      std::vector<int> corners;
      for (auto word = tokens.next(); !word.empty(); word = tokens.next())
        corners.push_back(parse_corner(word, mesh.vertices.size(), name, line_number));
      if (corners.size() < 3) fail(name, line_number, "has a face of fewer than three points");
      for (std::size_t c = 2; c < corners.size(); ++c)
        mesh.triangles.push_back({corners[0], corners[c - 1], corners[c]});
    }
  }
  return result;
}

}  // namespace angio::viewer::detail
