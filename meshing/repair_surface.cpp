#include "meshing/repair_surface.hpp"

#include <cmath>
#include <cstdio>
#include <utility>

#include "core/error.hpp"
#include "core/surface_rims.hpp"
#include "meshing/detail/edge_table.hpp"
#include "meshing/detail/long_edges.hpp"
#include "meshing/detail/mend_holes.hpp"
#include "meshing/detail/pieces.hpp"
#include "meshing/detail/sheets.hpp"
#include "meshing/detail/soup.hpp"
#include "meshing/detail/twists.hpp"

namespace angio::meshing {
namespace {

using detail::Count;

/// The surface on its way, with the list of what was done.
struct Work {
  TriangleMesh mesh;
  std::vector<SurfaceRepair> repairs;
  void note(const char* one, const char* many, const Count& count) {
    detail::note(repairs, one, many, count);
  }
};

void check_numbers(const TriangleMesh& mesh) {
  if (mesh.triangles.empty())
    throw InputError("the surface has no triangles (there is nothing to work on). Check the file");
  for (const Vec3& p : mesh.vertices)
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      throw InputError(
          "the surface has a vertex that is not a number (the file is damaged). Export it again");
  for (const Triangle& t : mesh.triangles)
    for (const int v : t)
      if (v < 0 || v >= int(mesh.vertices.size()))
        throw InputError(
            "the surface has a triangle with a missing vertex (the file is damaged). Export it "
            "again");
}

void check_edges(const TriangleMesh& mesh) {
  const SurfaceTopology topology = surface_topology(mesh);
  if (topology.nonmanifold_edge_count > 0)
    throw InputError(
        "the surface has " + std::to_string(topology.nonmanifold_edge_count) +
        " edges where its sheets could not be taken apart. Repair it in a mesh editor");
}

/// One vertex a place, one sheet an edge.
void make_manifold(Work& work) {
  constexpr double kSame = 1e-5;  // of the median edge
  const double tolerance = kSame * detail::median_edge_length(work.mesh);
  work.note("corner at the same point as another merged", "corners at the same point merged",
            detail::merge_points(work.mesh, 0.0));
  if (!work.repairs.empty()) work.repairs.back().is_routine = true;
  work.note("point that all but coincides with another merged",
            "points that all but coincide merged", detail::merge_points(work.mesh, tolerance));
  work.note("triangle without area dropped", "triangles without area dropped",
            detail::drop_degenerate(work.mesh, tolerance));
  work.note("repeated triangle dropped", "repeated triangles dropped",
            detail::drop_duplicates(work.mesh));
  work.note("T-junction joined", "T-junctions joined",
            detail::join_t_junctions(work.mesh, 100.0 * tolerance));
  work.note("repeated triangle of a joint dropped", "repeated triangles of joints dropped",
            detail::drop_duplicates(work.mesh));
  work.note("triangle of a sheet that hangs on the wall cut off",
            "triangles of sheets that hang on the wall cut off", detail::cut_off_fins(work.mesh));
  if (work.mesh.triangles.empty())
    throw InputError("nothing is left of the surface (its triangles have no area). Check its unit");
  work.note("triangle that turned the surface inside out cut out",
            "triangles that turned the surface inside out cut out",
            detail::cut_out_twists(work.mesh));
  work.note("triangle turned like its neighbours", "triangles turned like their neighbours",
            detail::turn_alike(work.mesh));
  work.note("corner where several sheets meet taken apart",
            "corners where several sheets meet taken apart", detail::take_sheets_apart(work.mesh));
  check_edges(work.mesh);
}

/// The diameter of the tube that has the surface's volume V for its area A, 4 V / A: about that of
/// its widest vessels. Openings count as closed by fans.
double mean_diameter(const TriangleMesh& mesh, const std::vector<SurfaceRim>& rims) {
  double volume_sixfold = 0.0, area = 0.0;
  const Vec3 origin = mesh.vertices.front();
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    volume_sixfold += dot(a - origin, cross(b - origin, c - origin));
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    add(detail::corner(mesh, t, 0), detail::corner(mesh, t, 1), detail::corner(mesh, t, 2));
    area += 0.5 * norm(area_vector_doubled(mesh, mesh.triangles[t]));
  }
  for (const SurfaceRim& rim : rims)
    for (std::size_t i = 0; i < rim.loop.size(); ++i)
      add(mesh.vertices[std::size_t(rim.loop[i])],
          mesh.vertices[std::size_t(rim.loop[(i + 1) % rim.loop.size()])], rim.centre);
  return area > 0.0 ? 4.0 * std::abs(volume_sixfold) / 6.0 / area : 0.0;
}

/// Openings that are holes in the wall are filled; those that are ends of vessels stay.
void fill_holes(Work& work) {
  constexpr double kInnerEnd = -0.8;  // of the wall runs along the opening: the end of the inner
                                      // side of a wall that has both sides
  constexpr double kLeast = 0.01;     // of the widest vessels' diameter: no scan shows both
  constexpr int kEach = 5;            // as many holes are told one by one
  std::vector<Count> holes;
  Count filled;
  const std::vector<SurfaceRim> rims = surface_rims(work.mesh);
  const double least = kLeast * mean_diameter(work.mesh, rims);
  for (const SurfaceRim& rim : rims) {
    const bool is_end = rim.wall_along >= kVesselEnd || rim.wall_along <= kInnerEnd;
    if (rim.loop.size() > 3 && is_end && rim.diameter_mm >= least) continue;
    holes.emplace_back().add(rim.centre, rim.diameter_mm);
    filled.add(rim.centre, rim.diameter_mm);
    detail::fill_hole_fair(work.mesh, rim.loop);
  }
  if (filled.count > kEach) holes = {filled};
  for (const Count& hole : holes)
    work.note("hole in the wall filled", "holes in the wall filled", hole);
}

}  // namespace

std::string to_text(const SurfaceRepair& repair) {
  char place[160];
  char size[48] = "";
  const bool one = repair.count == 1;
  if (repair.size_mm > 0.0)
    std::snprintf(size, sizeof size, one ? " of %.2f mm" : " the largest of %.2f mm",
                  repair.size_mm);
  else if (!one)
    std::snprintf(size, sizeof size, " one");
  std::snprintf(place, sizeof place, ",%s at (%.2f, %.2f, %.2f) mm", size, repair.where.x,
                repair.where.y, repair.where.z);
  return std::to_string(repair.count) + " " + repair.what + place;
}

RepairedSurface repair_surface(const TriangleMesh& surface, const SurfaceRepairOptions& options) {
  check_numbers(surface);
  Work work{surface, {}};
  make_manifold(work);
  work.mesh = detail::settle_pieces(work.mesh, options, work.repairs);
  fill_holes(work);
  work.mesh = detail::without_crossings(work.mesh, work.repairs);
  check_edges(work.mesh);
  work.note("edge longer than the lumen is wide split", "edges longer than the lumen is wide split",
            detail::split_long_edges(work.mesh));
  return {std::move(work.mesh), std::move(work.repairs)};
}

}  // namespace angio::meshing
