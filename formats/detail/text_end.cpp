#include <array>
#include <set>

#include "core/error.hpp"
#include "formats/detail/surface_formats.hpp"

namespace angio::formats::detail {

void require_whole_last_face(std::string_view text, const TriangleMesh& mesh, std::size_t last_face,
                             const std::string& name) {
  if (text.empty() || text.back() == '\n' || text.back() == '\r' || last_face == 0) return;
  // By place, as some programs give every face points of its own.
  using Place = std::array<double, 3>;
  using Edge = std::array<Place, 2>;
  const auto edge_of = [&](const Triangle& t, std::size_t c) {
    const auto place = [&](int v) {
      const Vec3& p = mesh.vertices[std::size_t(v)];
      return Place{p.x, p.y, p.z};
    };
    Place a = place(t[c]), b = place(t[(c + 1) % 3]);
    if (b < a) std::swap(a, b);
    return Edge{a, b};
  };
  std::set<Edge> alone;
  for (std::size_t t = mesh.triangles.size() - last_face; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const Edge edge = edge_of(mesh.triangles[t], c);
      if (!alone.erase(edge)) alone.insert(edge);  // the inner edges of a polygon come twice
    }
  for (std::size_t t = 0; t + last_face < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) alone.erase(edge_of(mesh.triangles[t], c));
  if (!alone.empty())
    throw InputError(name +
                     " ends without a line break, and its last face does not fit those around it "
                     "(it was cut short). Copy or export it again, or add a line break if it is "
                     "whole");
}

}  // namespace angio::formats::detail
