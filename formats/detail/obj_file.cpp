#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "core/triangle_mesh.hpp"
#include "formats/detail/header_text.hpp"
#include "formats/detail/surface_formats.hpp"
#include "formats/text.hpp"
#include "formats/tokens.hpp"

namespace angio::formats::detail {
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

/// What a file holds, and what its comments say that it holds.
struct Counts {
  std::size_t points = 0, points_promised = 0;
  std::size_t faces = 0, faces_promised = 0;
};

/// "# Faces: 12", as MeshLab writes, or "# 12 faces", as 3ds Max does for each object.
void add_promise(Counts& counts, std::string_view comment) {
  Tokens tokens(comment);
  tokens.next();  // "#"
  std::string_view first = tokens.next();
  std::string_view second = tokens.next();
  if (!tokens.next().empty() || second.empty()) return;
  if (first.ends_with(':')) {
    first.remove_suffix(1);
    std::swap(first, second);
  }
  const auto count = parse_number<std::size_t>(first);
  if (!count) return;
  if (second == "Vertices" || second == "vertices") counts.points_promised += *count;
  if (second == "Faces" || second == "faces" || second == "polygons" || second == "triangles")
    counts.faces_promised += *count;
}

/// The format has no count and no end. What still shows that the file was cut: comments that
/// promise more, a last number that was cut, points at the end that nothing uses: more than
/// one, or, beside a surface without a gap, more than one in a hundred.
void check_end(std::string_view bytes, const TriangleMesh& mesh, const Counts& counts,
               std::size_t last_used, std::size_t last_face, const std::string& name) {
  if (counts.faces < counts.faces_promised || counts.points < counts.points_promised)
    throw InputError(name + " holds " + std::to_string(counts.faces) + " faces and " +
                     std::to_string(counts.points) + " points where its comments say " +
                     std::to_string(counts.faces_promised) + " and " +
                     std::to_string(counts.points_promised) +
                     " (it was cut short). Copy or export it again");
  require_whole_last_face(bytes, mesh, last_face, name);
  // Points without a face that a program may leave behind; of a closed surface, in which no gap
  // shows that faces are missing, more, but no second surface.
  constexpr std::size_t kStray = 1, kStrayOfClosed = 100;  // the latter: one point in so many
  const std::size_t loose = mesh.vertices.size() - last_used;
  if (!mesh.triangles.empty() && loose > kStray &&
      (loose > mesh.vertices.size() / kStrayOfClosed ||
       surface_topology(mesh).boundary_edge_count > 0))
    throw InputError(name + " ends before its faces use the last " + std::to_string(loose) +
                     " points (it was cut short). Copy or export it again, without loose points");
}

}  // namespace

ParsedSurface parse_obj(std::string_view bytes, const std::string& name) {
  ParsedSurface result;
  TriangleMesh& mesh = result.data.mesh;
  Counts counts;
  std::size_t last_used = 0;  // points up to here are of a face, a line or a point element
  std::size_t last_face = 0;  // in triangles; 0 while something else comes last
  Lines lines(bytes);
  int line_number = 0;
  while (const auto line = lines.next()) {
    ++line_number;
    Tokens tokens(*line);
    const std::string_view kind = tokens.next();
    if (!kind.empty()) last_face = 0;
    if (kind.starts_with('#')) {
      result.in_ras |= says_ras(*line);
      if (const auto unit = stated_unit(*line)) result.data.unit = unit;
      add_promise(counts, *line);
    }
    if (kind == "v") {
      Vec3 point;
      for (int axis = 0; axis < 3; ++axis) {
        const auto number = parse_number<double>(tokens.next());
        if (!number) fail(name, line_number, "has a point that is not three numbers");
        point[axis] = *number;
      }
      mesh.vertices.push_back(point);
      ++counts.points;
    } else if (kind == "f" || kind == "l" || kind == "p") {
      std::vector<int> corners;
      for (auto word = tokens.next(); !word.empty(); word = tokens.next()) {
        corners.push_back(parse_corner(word, mesh.vertices.size(), name, line_number));
        last_used = std::max(last_used, std::size_t(corners.back()) + 1);
      }
      if (corners.size() < 3 && lines.position() >= bytes.size() && bytes.back() != '\n')
        fail(name, line_number, "ends in a face of fewer than three points");
      if (kind != "f" || corners.size() == 2) continue;  // an edge encloses nothing
      ++counts.faces;
      last_face = corners.size() - 2;
      if (corners.size() < 3) fail(name, line_number, "has a face of fewer than three points");
      for (std::size_t c = 2; c < corners.size(); ++c)
        mesh.triangles.push_back({corners[0], corners[c - 1], corners[c]});
    }
  }
  check_end(bytes, mesh, counts, last_used, last_face, name);
  return result;
}

std::string obj_text(const TriangleMesh& mesh) {
  std::string text = "# SPACE=LPS unit=mm\n";
  for (const Vec3& point : mesh.vertices)
    text += "v " + number_text(point.x) + ' ' + number_text(point.y) + ' ' + number_text(point.z) +
            '\n';
  for (const Triangle& corners : mesh.triangles) {
    text += 'f';
    for (const int corner : corners) text += ' ' + std::to_string(corner + 1);
    text += '\n';
  }
  return text;
}

}  // namespace angio::formats::detail
