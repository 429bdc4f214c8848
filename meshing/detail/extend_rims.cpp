#include "meshing/detail/extend_rims.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "air_mesh/build/surface_crossings.hpp"
#include "meshing/detail/cap_rims.hpp"
#include "meshing/detail/open_ends.hpp"

namespace angio::meshing::detail {
namespace {

/// A rim seen along its axis.
struct RimShape {
  Vec3 centre, u, v, axis;
  double radius = 0.0;            ///< of the circle of equal area [mm]
  double corner_radius = 0.0;     ///< of the regular polygon of equal area [mm]
  double edge = 0.0;              ///< mean length [mm]
  double first_angle = 0.0;       ///< of vertex 0 on the circle
  std::vector<Vec3> from_centre;  ///< of each vertex
};

RimShape describe(const TriangleMesh& mesh, const std::vector<int>& loop, const Vec3& axis) {
  RimShape rim;
  const std::size_t n = loop.size();
  rim.axis = axis;
  rim.u = any_perpendicular(axis);
  rim.v = cross(axis, rim.u);
  const auto at = [&](std::size_t i) { return mesh.vertices[std::size_t(loop[i % n])]; };
  // Of the area, not of the vertices: these may lie unevenly.
  Vec3 moment;
  double area_doubled = 0.0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double part = dot(cross(at(i) - at(0), at(i + 1) - at(0)), axis);
    moment += part / 3.0 * (at(0) + at(i) + at(i + 1));
    area_doubled += part;
  }
  rim.centre = moment / area_doubled;
  rim.radius = std::sqrt(0.5 * std::abs(area_doubled) / std::numbers::pi);
  const double step = 2.0 * std::numbers::pi / double(n);
  rim.corner_radius = rim.radius * std::sqrt(step / std::sin(step));
  double sine = 0.0;
  double cosine = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    rim.from_centre.push_back(at(i) - rim.centre);
    rim.edge += distance(at(i), at(i + 1)) / double(n);
    const double angle =
        std::atan2(dot(rim.from_centre[i], rim.v), dot(rim.from_centre[i], rim.u)) -
        2.0 * std::numbers::pi * double(i) / double(n);
    sine += std::sin(angle);
    cosine += std::cos(angle);
  }
  rim.first_angle = std::atan2(sine, cosine);
  return rim;
}

/// Vertex i of the ring at a height over the rim.
Vec3 ring_point(const RimShape& rim, std::size_t i, double height) {
  const double x = std::clamp(height / (2.0 * rim.radius), 0.0, 1.0);
  const double round = x * x * (3.0 - 2.0 * x);  // leaves and arrives along the axis
  const double angle =
      rim.first_angle + 2.0 * std::numbers::pi * double(i) / double(rim.from_centre.size());
  const Vec3 on_circle = rim.corner_radius * (std::cos(angle) * rim.u + std::sin(angle) * rim.v);
  return rim.centre + height * rim.axis + (1.0 - round) * rim.from_centre[i] + round * on_circle;
}

/// @return whether the extension had to be lengthened: below an edge's length are only flat
/// triangles
bool extend(SurfaceDraft& draft, const std::vector<int>& loop, double diameters) {
  const int id = draft.rim[std::size_t(loop.front())];
  const Vec3 axis = draft.rim_planes[std::size_t(id)].normal;
  const RimShape rim = describe(draft.mesh, loop, axis);
  const double wished = 2.0 * rim.radius * diameters, length = std::max(wished, rim.edge);
  const int ring_count = std::max(2, int(std::lround(length / rim.edge)));
  const std::size_t n = loop.size();
  std::vector<int> below = loop;
  for (int ring = 1; ring <= ring_count; ++ring) {
    std::vector<int> above;
    for (std::size_t i = 0; i < n; ++i) {
      above.push_back(int(draft.mesh.vertices.size()));
      draft.mesh.vertices.push_back(ring_point(rim, i, length * ring / ring_count));
      draft.edge_length.push_back(rim.edge);
      draft.rim.push_back(ring == ring_count ? id : -1);
      draft.membrane.push_back(0);
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i + 1) % n;
      const Vec3& p = draft.mesh.vertices[std::size_t(below[i])];
      const Vec3& q = draft.mesh.vertices[std::size_t(above[j])];
      const Vec3& r = draft.mesh.vertices[std::size_t(below[j])];
      const Vec3& s = draft.mesh.vertices[std::size_t(above[i])];
      if (distance(p, q) <= distance(r, s)) {
        draft.mesh.triangles.push_back({below[i], below[j], above[j]});
        draft.mesh.triangles.push_back({below[i], above[j], above[i]});
      } else {
        draft.mesh.triangles.push_back({below[i], below[j], above[i]});
        draft.mesh.triangles.push_back({below[j], above[j], above[i]});
      }
    }
    below = above;
  }
  for (const int v : loop) draft.rim[std::size_t(v)] = -1;
  draft.rim_planes[std::size_t(id)].origin += length * axis;
  return length > wished;
}

}  // namespace

void extend_rims(SurfaceDraft& draft, double diameters, std::vector<std::string>& warnings) {
  if (diameters <= 0.0) return;
  std::string left_out;
  bool any_longer = false;
  for (const std::vector<int>& loop : boundary_loops(draft.mesh)) {
    SurfaceDraft extended = draft;
    const bool is_longer = extend(extended, loop, diameters);
    const CappedMesh capped = cap_rims(extended.mesh, extended.rim);
    std::vector<char> is_new(capped.mesh.triangles.size(), 0);
    for (std::size_t t = draft.mesh.triangles.size(); t < extended.mesh.triangles.size(); ++t)
      is_new[t] = 1;
    if (air_mesh::self_intersections_of(capped.mesh, is_new).empty()) {
      draft = std::move(extended);
      any_longer |= is_longer;
    } else {
      left_out +=
          (left_out.empty() ? "" : ", ") + name_of_end(draft.rim[std::size_t(loop.front())]);
    }
  }
  if (any_longer)
    warnings.push_back(
        "extensions were lengthened to an edge of the mesh (mesh.extension_diameters asks for "
        "less)");
  if (!left_out.empty())
    warnings.push_back("these ends get no extension, because it would cross the lumen: " +
                       left_out);
}

}  // namespace angio::meshing::detail
