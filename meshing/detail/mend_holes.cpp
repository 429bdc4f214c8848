#include "meshing/detail/mend_holes.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

#include <exception>
#include <tuple>

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
    if (border != Mesh::null_halfedge() && surface.is_border(border)) {
      std::vector<Mesh::Face_index> faces;
      std::vector<Mesh::Vertex_index> vertices;
      const bool is_fair = std::get<0>(pmp::triangulate_refine_and_fair_hole(
          surface, border, std::back_inserter(faces), std::back_inserter(vertices)));
      if (is_fair && !faces.empty()) {
        mesh = from_cgal(surface);
        return;
      }
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
