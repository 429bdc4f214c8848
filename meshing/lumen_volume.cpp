#include "meshing/lumen_volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "air_mesh/build/tet_shape.hpp"
#include "air_mesh/build/tetgen_child.hpp"
#include "core/error.hpp"
#include "meshing/detail/edge_lengths.hpp"
#include "meshing/detail/improve_tets.hpp"
#include "meshing/detail/remesh_caps.hpp"

namespace angio::meshing {
namespace {

/// The cap that each triangle of the capped lumen is of; 0: it is of the wall. A lumen of a fixed
/// count of triangles has caps in its open surface, too, and no cap of its own over some rims.
std::vector<int> caps_of_triangles(const LumenMesh& lumen) {
  std::vector<char> at_border(lumen.capped.vertices.size(), 0);
  for (const std::vector<int>& loop : boundary_loops(lumen.open))
    for (const int v : loop) at_border[std::size_t(v)] = 1;
  std::vector<int> caps;
  for (const Triangle& t : lumen.capped.triangles) {
    const bool is_open = caps.size() < lumen.open.triangles.size();
    const int id = lumen.inlet_outlet_id[std::size_t(t[0])];
    const auto has_id = [&](int v) { return lumen.inlet_outlet_id[std::size_t(v)] == id; };
    const auto is_at_border = [&](int v) { return at_border[std::size_t(v)] != 0; };
    // A triangle of the wall may have its corners on one rim.
    const bool is_walls = is_open && std::all_of(t.begin(), t.end(), is_at_border);
    caps.push_back(std::all_of(t.begin(), t.end(), has_id) && !is_walls ? id : 0);
  }
  return caps;
}

/// The lumen's closed surface, with caps whose triangles are like the wall's.
struct Shell {
  TriangleMesh mesh;           ///< the wall's vertices and triangles first
  std::vector<int> entity_id;  ///< per triangle
};

/// @param place  of the wall's vertices in the shell; -1 for others
void add_cap(Shell& shell, const LumenMesh& lumen, const std::vector<Triangle>& triangles, int id,
             const std::vector<int>& place) {
  TriangleMesh cap;
  std::vector<int> whole;  // vertex of the shell for each rim vertex of the cap
  std::vector<char> on_rim;
  std::map<int, int> index;
  for (const Triangle& t : triangles)
    for (const int v : t) index[v] = -1;
  for (const bool rims : {true, false})  // rim vertices first
    for (auto& [v, own] : index) {
      if ((place[std::size_t(v)] >= 0) != rims) continue;
      own = int(cap.vertices.size());
      cap.vertices.push_back(lumen.capped.vertices[std::size_t(v)]);
      on_rim.push_back(rims ? 1 : 0);
      if (rims) whole.push_back(place[std::size_t(v)]);
    }
  for (const Triangle& t : triangles)
    cap.triangles.push_back({index.at(t[0]), index.at(t[1]), index.at(t[2])});
  cap = detail::remeshed_cap(cap, on_rim);
  for (std::size_t v = whole.size(); v < cap.vertices.size(); ++v) {
    whole.push_back(int(shell.mesh.vertices.size()));
    shell.mesh.vertices.push_back(cap.vertices[v]);
  }
  for (const Triangle& t : cap.triangles) {
    shell.mesh.triangles.push_back(
        {whole[std::size_t(t[0])], whole[std::size_t(t[1])], whole[std::size_t(t[2])]});
    shell.entity_id.push_back(kWallEntityId + id);
  }
}

Shell make_shell(const LumenMesh& lumen) {
  const std::vector<int> caps = caps_of_triangles(lumen);
  std::map<int, std::vector<Triangle>> triangles;  // by cap; 0: the wall's
  for (std::size_t t = 0; t < caps.size(); ++t)
    triangles[caps[t]].push_back(lumen.capped.triangles[t]);
  std::vector<int> place(lumen.capped.vertices.size(), -1);
  for (const Triangle& t : triangles[0])
    for (const int v : t) place[std::size_t(v)] = 0;
  Shell shell;
  for (std::size_t v = 0; v < place.size(); ++v) {
    if (place[v] < 0) continue;
    place[v] = int(shell.mesh.vertices.size());
    shell.mesh.vertices.push_back(lumen.capped.vertices[v]);
  }
  for (const auto& [id, own] : triangles) {
    if (id > 0) {
      add_cap(shell, lumen, own, id, place);
      continue;
    }
    for (const Triangle& t : own)
      shell.mesh.triangles.push_back(
          {place[std::size_t(t[0])], place[std::size_t(t[1])], place[std::size_t(t[2])]});
    shell.entity_id.assign(own.size(), kWallEntityId);
  }
  return shell;
}

/// TetGen's mesh, right-handed, with the shell's own vertices bit for bit.
TetMesh fill_shell(const Shell& shell, const LumenVolumeOptions& options,
                   std::vector<std::string>& warnings) {
  constexpr double kLimit = 300.0;  // [s]
  constexpr int kAttempts = 4;
  Vec3 centre;
  for (const Vec3& p : shell.mesh.vertices)
    centre += (1.0 / double(shell.mesh.vertices.size())) * p;
  air_mesh::TetgenInput input;
  for (const Vec3& p : shell.mesh.vertices) input.vertices.push_back(p - centre);
  input.triangles = shell.mesh.triangles;
  input.switches = "pYYq1.4/14mQ";
  input.what = "the lumen";
  double ratio = options.edge_ratio;
  TetMesh mesh;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    input.edge_lengths = detail::mean_edge_lengths(shell.mesh);
    for (double& length : input.edge_lengths) length *= ratio;
    mesh = air_mesh::run_tetgen(input, kLimit);
    const double excess = double(mesh.tets.size()) / options.tet_budget;
    if (excess <= 1.0) break;
    ratio *= 1.1 * std::cbrt(excess);
  }
  if (ratio > options.edge_ratio)
    warnings.push_back("the edges inside the lumen were lengthened by " +
                       std::to_string(std::lround(100.0 * (ratio / options.edge_ratio - 1.0))) +
                       " % to keep the budget of tetrahedra");
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.vertices[v] =
        v < shell.mesh.vertices.size() ? shell.mesh.vertices[v] : mesh.vertices[v] + centre;
  for (Tet& t : mesh.tets)
    if (tet_volume(mesh.vertices[std::size_t(t[0])], mesh.vertices[std::size_t(t[1])],
                   mesh.vertices[std::size_t(t[2])], mesh.vertices[std::size_t(t[3])]) < 0.0)
      std::swap(t[2], t[3]);
  return mesh;
}

std::vector<Triangle> sorted_outer_faces(const TetMesh& mesh) {
  std::vector<Triangle> faces;
  for (const Tet& t : mesh.tets)
    for (std::size_t lacks = 0; lacks < 4; ++lacks) {
      Triangle face{t[(lacks + 1) % 4], t[(lacks + 2) % 4], t[(lacks + 3) % 4]};
      std::sort(face.begin(), face.end());
      faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end());
  std::vector<Triangle> outer;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + 1 < faces.size() && faces[i] == faces[i + 1])
      ++i;
    else
      outer.push_back(faces[i]);
  }
  return outer;
}

/// Every triangle of the shell is a face of one tetrahedron, and no other face is.
void check_conformity(const TetMesh& mesh, const Shell& shell) {
  std::vector<Triangle> wanted = shell.mesh.triangles;
  for (Triangle& t : wanted) std::sort(t.begin(), t.end());
  std::sort(wanted.begin(), wanted.end());
  if (sorted_outer_faces(mesh) != wanted)
    throw InternalError("the lumen's tetrahedra do not keep the triangles of its wall");
}

void measure(LumenVolume& volume) {
  air_mesh::DihedralRange range;
  for (const Tet& t : volume.mesh.tets) {
    const auto at = [&](std::size_t c) -> const Vec3& {
      return volume.mesh.vertices[std::size_t(t[c])];
    };
    const air_mesh::DihedralRange own = air_mesh::dihedral_range(at(0), at(1), at(2), at(3));
    constexpr double kSharp = 12.0;  // [degrees]
    volume.sharp_tet_count += own.least < kSharp ? 1 : 0;
    range.least = std::min(range.least, own.least);
    range.greatest = std::max(range.greatest, own.greatest);
    const double size = tet_volume(at(0), at(1), at(2), at(3));
    if (!(size > 0.0)) throw InternalError("a tetrahedron of the lumen is flat or turned over");
    volume.volume_mm3 += size;
  }
  if (volume.sharp_tet_count > 0)
    volume.warnings.push_back(
        std::to_string(volume.sharp_tet_count) +
        " tetrahedra of the lumen keep a dihedral angle below 12 degrees (the "
        "wall is too narrow or too sharply bent there)");
  volume.min_dihedral_degrees = range.least;
  volume.max_dihedral_degrees = range.greatest;
}

}  // namespace

LumenVolume mesh_lumen_volume(const LumenMesh& lumen, const LumenVolumeOptions& options,
                              const Progress& progress) {
  options.validate();
  if (!lumen.watertight || lumen.self_intersection_count > 0)
    throw InputError(
        "the lumen's surface is not watertight or crosses itself (it has no inside to fill). Mesh "
        "the lumen again");
  LumenVolume volume;
  progress.report(0.0, "caps");
  Shell shell = make_shell(lumen);
  progress.report(0.1, "tetrahedra");
  volume.mesh = fill_shell(shell, options, volume.warnings);
  progress.report(0.5, "improving tetrahedra");
  detail::improve_tets(volume.mesh, int(shell.mesh.vertices.size()),
                       options.least_dihedral_degrees);
  progress.report(0.9, "checks");
  check_conformity(volume.mesh, shell);
  volume.boundary = std::move(shell.mesh.triangles);
  volume.boundary_entity_id = std::move(shell.entity_id);
  measure(volume);
  progress.report(1.0);
  return volume;
}

}  // namespace angio::meshing
