#include "meshing/detail/mend_holes.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/fair.h>
#include <CGAL/Polygon_mesh_processing/refine.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <map>
#include <utility>

#include "air_mesh/build/patch_weight.hpp"
#include "meshing/detail/fill_hole.hpp"

namespace angio::meshing::detail {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace pmp = CGAL::Polygon_mesh_processing;

/// @return no faces if the triangles are not manifold
Mesh to_cgal(const TriangleMesh& mesh) {
  Mesh result;
  for (const Vec3& p : mesh.vertices) result.add_vertex({p.x, p.y, p.z});
  for (const Triangle& t : mesh.triangles)
    if (result.add_face(Mesh::Vertex_index(unsigned(t[0])), Mesh::Vertex_index(unsigned(t[1])),
                        Mesh::Vertex_index(unsigned(t[2]))) == Mesh::null_face())
      return {};
  return result;
}

TriangleMesh from_cgal(const Mesh& mesh) {
  TriangleMesh result;
  for (const auto v : mesh.vertices())
    result.vertices.push_back({mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z()});
  for (const auto f : mesh.faces()) {
    const auto h = mesh.halfedge(f);
    result.triangles.push_back({int(mesh.source(h).idx()), int(mesh.target(h).idx()),
                                int(mesh.target(mesh.next(h)).idx())});
  }
  return result;
}

/// Edges between corners of a hole other than its own sides, as pairs of places along it.
std::vector<std::pair<int, int>> edges_across(const Mesh& mesh,
                                              const std::vector<Mesh::Halfedge_index>& hole) {
  const int count = int(hole.size());
  std::map<Mesh::Vertex_index, int> place;
  for (int i = 0; i < count; ++i) place[mesh.target(hole[std::size_t(i)])] = i;
  std::vector<std::pair<int, int>> edges;
  for (int i = 0; i < count; ++i)
    for (const auto h : CGAL::halfedges_around_target(hole[std::size_t(i)], mesh)) {
      const auto other = place.find(mesh.source(h));
      if (other == place.end()) continue;
      const int j = other->second;
      if (i + 1 < j && (i != 0 || j + 1 != count)) edges.emplace_back(i, j);
    }
  return edges;
}

/// Triangles between a hole's corners; none if it touches itself or has no triangulation.
std::vector<Mesh::Face_index> triangulate_hole(Mesh& mesh, Mesh::Halfedge_index border) {
  std::vector<Mesh::Halfedge_index> hole;
  std::vector<Kernel::Point_3> points, across;
  for (const auto h : CGAL::halfedges_around_face(border, mesh)) {
    hole.push_back(h);
    points.push_back(mesh.point(mesh.target(h)));
    across.push_back(mesh.point(mesh.target(mesh.next(mesh.opposite(mesh.next(h))))));
  }
  std::vector<Mesh::Vertex_index> corners;
  for (const auto h : hole) corners.push_back(mesh.target(h));
  std::sort(corners.begin(), corners.end());
  std::vector<Mesh::Face_index> faces;
  if (std::adjacent_find(corners.begin(), corners.end()) != corners.end()) return faces;
  auto existing = edges_across(mesh, hole);
  pmp::internal::Tracer_polyhedron<Mesh, std::back_insert_iterator<decltype(faces)>> tracer(
      std::back_inserter(faces), mesh, hole);
  air_mesh::fill_loop<Kernel>(
      points, across, CGAL::internal::Is_valid_existing_edges_and_degenerate_triangle(existing),
      tracer);
  return faces;
}

/// Liepa's filling. @return false if it cannot be formed
bool fill_fair(Mesh& mesh, Mesh::Halfedge_index border) {
  std::vector<Mesh::Face_index> faces = triangulate_hole(mesh, border);
  if (faces.empty()) return false;
  std::vector<Mesh::Face_index> refined;
  std::vector<Mesh::Vertex_index> inner;
  pmp::refine(mesh, faces, std::back_inserter(refined), std::back_inserter(inner));
  return pmp::fair(mesh, inner);
}

}  // namespace

void fill_hole_fair(TriangleMesh& mesh, const std::vector<int>& loop) {
  constexpr std::size_t kSmall = 5;  // corners; nothing to fair
  if (loop.size() > kSmall) {
    Mesh surface = to_cgal(mesh);
    const auto from = Mesh::Vertex_index(unsigned(loop[0]));
    const auto to = Mesh::Vertex_index(unsigned(loop[1]));
    Mesh::Halfedge_index border =
        surface.number_of_faces() > 0 ? surface.halfedge(from, to) : Mesh::null_halfedge();
    if (border != Mesh::null_halfedge() && !surface.is_border(border))
      border = surface.opposite(border);
    if (border != Mesh::null_halfedge() && surface.is_border(border) &&
        fill_fair(surface, border)) {
      mesh = from_cgal(surface);
      return;
    }
  }
  fill_hole(mesh, loop);
}

bool unite_solids(TriangleMesh& a, const TriangleMesh& b) {
  Mesh first = to_cgal(a);
  Mesh second = to_cgal(b);
  Mesh united;
  try {
    if (!pmp::corefine_and_compute_union(first, second, united,
                                         pmp::parameters::throw_on_self_intersection(true),
                                         pmp::parameters::throw_on_self_intersection(true)))
      return false;
  } catch (const std::exception&) {
    return false;
  }
  united.collect_garbage();
  a = from_cgal(united);
  return true;
}

}  // namespace angio::meshing::detail
