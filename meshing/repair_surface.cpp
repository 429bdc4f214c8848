#include "meshing/repair_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/error.hpp"
#include "meshing/detail/crossings.hpp"
#include "meshing/detail/fill_hole.hpp"
#include "meshing/detail/mend_holes.hpp"
#include "meshing/detail/soup.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing {
namespace {

using detail::Count;

/// The surface on its way, with the list of what was done.
struct Work {
  TriangleMesh mesh;
  std::vector<SurfaceRepair> repairs;
  void note(const char* one, const char* many, const Count& count) {
    if (count.count > 0)
      repairs.push_back({count.count == 1 ? one : many, count.count, count.where});
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
  work.note("triangle of a sheet that hangs on the wall cut off",
            "triangles of sheets that hang on the wall cut off", detail::cut_off_fins(work.mesh));
  if (work.mesh.triangles.empty())
    throw InputError("nothing is left of the surface (its triangles have no area). Check its unit");
  work.note("triangle turned like its neighbours", "triangles turned like their neighbours",
            detail::turn_alike(work.mesh));
  work.note("corner where several sheets meet taken apart",
            "corners where several sheets meet taken apart", detail::take_sheets_apart(work.mesh));
}

/// How much of a wall runs across the axis of its opening: 0 at the end of a vessel, 1 at a hole.
double wall_across_opening(const TriangleMesh& mesh, const std::vector<int>& loop,
                           const std::map<std::array<int, 2>, int>& triangle_at) {
  Vec3 area;
  const Vec3& origin = mesh.vertices[std::size_t(loop[0])];
  for (std::size_t i = 1; i + 1 < loop.size(); ++i)
    area += cross(mesh.vertices[std::size_t(loop[i])] - origin,
                  mesh.vertices[std::size_t(loop[i + 1])] - origin);
  const Vec3 axis = normalized(area);
  double across = 0.0;
  double whole = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const int a = loop[i];
    const int b = loop[(i + 1) % loop.size()];
    const auto found = triangle_at.find({std::min(a, b), std::max(a, b)});
    if (found == triangle_at.end()) continue;
    const double length = distance(mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)]);
    const Vec3 normal =
        normalized(area_vector_doubled(mesh, mesh.triangles[std::size_t(found->second)]));
    across += length * std::abs(dot(normal, axis));
    whole += length;
  }
  return whole > 0.0 ? across / whole : 1.0;
}

/// Openings that are holes in the wall, not ends of vessels.
std::vector<std::vector<int>> holes_in_wall(const TriangleMesh& mesh) {
  constexpr double kHole = 0.5;
  std::map<std::array<int, 2>, int> triangle_at;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = mesh.triangles[t][c];
      const int b = mesh.triangles[t][(c + 1) % 3];
      triangle_at[{std::min(a, b), std::max(a, b)}] = int(t);
    }
  std::vector<std::vector<int>> holes;
  for (const auto& loop : boundary_loops(mesh))
    if (loop.size() <= 3 || wall_across_opening(mesh, loop, triangle_at) > kHole)
      holes.push_back(loop);
  return holes;
}

void fill_holes(Work& work) {
  Count filled;
  for (const auto& loop : holes_in_wall(work.mesh)) {
    filled.add(work.mesh.vertices[std::size_t(loop[0])]);
    detail::fill_hole_fair(work.mesh, loop);
  }
  work.note("hole in the wall filled", "holes in the wall filled", filled);
}

/// Volume inside, openings closed by the shortest way.
double volume_when_closed(const TriangleMesh& mesh) {
  TriangleMesh closed = mesh;
  for (const auto& loop : boundary_loops(mesh)) detail::fill_hole(closed, loop);
  return enclosed_volume(closed);
}

/// The connected pieces, the one with the largest surface first, each turned outward.
std::vector<TriangleMesh> pieces_outward(Work& work) {
  const std::vector<int> component = detail::vertex_components(work.mesh);
  std::map<int, std::vector<char>> members;
  for (std::size_t t = 0; t < work.mesh.triangles.size(); ++t) {
    auto& keep = members[component[std::size_t(work.mesh.triangles[t][0])]];
    keep.resize(work.mesh.triangles.size(), 0);
    keep[t] = 1;
  }
  std::vector<TriangleMesh> pieces;
  Count turned;
  for (auto& [root, keep] : members) {
    pieces.push_back(members.size() == 1 ? work.mesh : detail::part_of(work.mesh, keep));
    if (volume_when_closed(pieces.back()) >= 0.0) continue;
    for (Triangle& t : pieces.back().triangles) std::swap(t[1], t[2]);
    turned.add(pieces.back().vertices.front());
  }
  work.note("inside-out piece turned outward", "inside-out pieces turned outward", turned);
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const auto& a, const auto& b) { return surface_area(a) > surface_area(b); });
  return pieces;
}

/// Unites closed pieces that cross; keeps the largest, or all.
void settle_pieces(Work& work, const SurfaceRepairOptions& options) {
  std::vector<TriangleMesh> pieces = pieces_outward(work);
  Count united;
  const auto is_closed = [](const TriangleMesh& m) { return surface_topology(m).is_closed(); };
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (std::size_t j = i + 1; j < pieces.size();) {
      if (!is_closed(pieces[i]) || !is_closed(pieces[j]) ||
          detail::intersections(pieces[i], pieces[j]).empty() ||
          !detail::unite_solids(pieces[i], pieces[j])) {
        ++j;
        continue;
      }
      united.add(pieces[j].vertices.front());
      pieces.erase(pieces.begin() + std::ptrdiff_t(j));
      j = i + 1;
    }
  work.note("piece that crosses the largest united with it",
            "pieces that cross united with the largest", united);
  Count left_out;
  work.mesh = pieces.front();
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    if (!options.keep_all_pieces) {
      left_out.add(pieces[i].vertices.front());
      continue;
    }
    const int offset = int(work.mesh.vertices.size());
    work.mesh.vertices.insert(work.mesh.vertices.end(), pieces[i].vertices.begin(),
                              pieces[i].vertices.end());
    for (const Triangle& t : pieces[i].triangles)
      work.mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  work.note("smaller piece left out", "smaller pieces left out", left_out);
}

void close_crossings(Work& work) {
  constexpr double kMost = 0.1;  // of the triangles
  const auto pairs = detail::self_intersections(work.mesh);
  if (pairs.empty()) return;
  std::vector<char> crossing(work.mesh.triangles.size(), 0);
  for (const auto& pair : pairs)
    for (const int t : pair) crossing[std::size_t(t)] = 1;
  const auto count = std::count(crossing.begin(), crossing.end(), char(1));
  const std::string share =
      std::to_string(std::lround(100.0 * double(count) / double(crossing.size()))) + " %";
  if (double(count) > kMost * double(crossing.size()))
    throw InputError("the surface crosses itself in " + share +
                     " of its triangles (too much to be closed anew without inventing a wall). "
                     "Segment again, or unite its parts in a mesh editor");
  Count closed;
  closed.where =
      work.mesh.vertices[std::size_t(work.mesh.triangles[std::size_t(pairs.front()[0])][0])];
  closed.count = detail::close_crossings(work.mesh);
  work.note("place where the surface crossed itself closed anew",
            "places where the surface crossed itself closed anew", closed);
}

void check_result(const TriangleMesh& mesh) {
  const SurfaceTopology topology = surface_topology(mesh);
  if (topology.nonmanifold_edge_count > 0)
    throw InputError(
        "the surface has " + std::to_string(topology.nonmanifold_edge_count) +
        " edges where its sheets could not be taken apart. Repair it in a mesh editor");
  const std::size_t crossing_count = detail::self_intersections(mesh).size();
  if (crossing_count > 0)
    throw InputError("the surface crosses itself (" + std::to_string(crossing_count) +
                     " pairs of triangles are left after repair). Repair it in a mesh editor");
}

}  // namespace

std::string to_text(const SurfaceRepair& repair) {
  char place[96];
  std::snprintf(place, sizeof place, ", one at (%.2f, %.2f, %.2f) mm", repair.where.x,
                repair.where.y, repair.where.z);
  return std::to_string(repair.count) + " " + repair.what + place;
}

RepairedSurface repair_surface(const TriangleMesh& surface, const SurfaceRepairOptions& options) {
  check_numbers(surface);
  Work work{surface, {}};
  make_manifold(work);
  settle_pieces(work, options);
  fill_holes(work);
  close_crossings(work);
  check_result(work.mesh);
  return {std::move(work.mesh), std::move(work.repairs)};
}

}  // namespace angio::meshing
