#include "meshing/lumen_volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "meshing/detail/edge_lengths.hpp"
#include "meshing/detail/improve_tets.hpp"
#include "meshing/detail/remesh_caps.hpp"
#include "meshing/detail/tet_shape.hpp"
#include "meshing/detail/tetgen_child.hpp"

namespace angio::meshing {
namespace {

/// The lumen's closed surface, with caps whose triangles are like the wall's.
struct Shell {
  TriangleMesh mesh;           ///< the open lumen's vertices and triangles first
  std::vector<int> entity_id;  ///< per triangle
};

void add_cap(Shell& shell, const LumenMesh& lumen, int id) {
  TriangleMesh cap;
  std::vector<int> whole;  // vertex of the shell for each rim vertex of the cap
  std::vector<char> on_rim;
  std::map<int, int> index;
  const auto open_count = int(lumen.open.vertices.size());
  for (const bool rims : {true, false})  // rim vertices first
    for (std::size_t v = 0; v < lumen.capped.vertices.size(); ++v) {
      if (lumen.inlet_outlet_id[v] != id || (int(v) < open_count) != rims) continue;
      index[int(v)] = int(cap.vertices.size());
      cap.vertices.push_back(lumen.capped.vertices[v]);
      on_rim.push_back(rims ? 1 : 0);
      if (rims) whole.push_back(int(v));
    }
  for (std::size_t t = lumen.open.triangles.size(); t < lumen.capped.triangles.size(); ++t) {
    const Triangle& c = lumen.capped.triangles[t];
    if (lumen.inlet_outlet_id[std::size_t(c[0])] == id)
      cap.triangles.push_back({index.at(c[0]), index.at(c[1]), index.at(c[2])});
  }
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
  Shell shell{lumen.open, std::vector<int>(lumen.open.triangles.size(), kWallEntityId)};
  int last = 0;
  for (const int id : lumen.inlet_outlet_id) last = std::max(last, id);
  for (int id = 1; id <= last; ++id)
    if (std::find(lumen.inlet_outlet_id.begin(), lumen.inlet_outlet_id.end(), id) !=
        lumen.inlet_outlet_id.end())
      add_cap(shell, lumen, id);
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
  detail::TetgenInput input;
  for (const Vec3& p : shell.mesh.vertices) input.vertices.push_back(p - centre);
  input.triangles = shell.mesh.triangles;
  input.switches = "pYYq1.4/14mQ";
  input.what = "the lumen";
  double ratio = options.edge_ratio;
  TetMesh mesh;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    input.edge_lengths = detail::mean_edge_lengths(shell.mesh);
    for (double& length : input.edge_lengths) length *= ratio;
    mesh = detail::run_tetgen(input, kLimit);
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
  detail::DihedralRange range;
  for (const Tet& t : volume.mesh.tets) {
    const auto at = [&](std::size_t c) -> const Vec3& {
      return volume.mesh.vertices[std::size_t(t[c])];
    };
    const detail::DihedralRange own = detail::dihedral_range(at(0), at(1), at(2), at(3));
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
