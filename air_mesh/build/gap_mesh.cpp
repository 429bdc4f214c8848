#include "air_mesh/build/gap_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

#include "air_mesh/build/build_air.hpp"
#include "air_mesh/build/distances_ahead.hpp"
#include "air_mesh/build/lift_points.hpp"
#include "air_mesh/build/tetgen_child.hpp"
#include "air_mesh/tet_flips.hpp"
#include "air_mesh/tet_refill.hpp"
#include "core/error.hpp"

namespace angio::air_mesh {
namespace {

// [mm] One after the other: folded balloons need none, and some regular ones do.
constexpr std::array<double, 7> kJitters{0.0, 1e-4, 1e-4, 1e-5, 1e-4, 1e-3, 1e-5};
constexpr int kJitterAttempts = int(kJitters.size());
constexpr const char* kKeepingSurfaces = "pYYQ";  // TetGen's switches
constexpr const char* kFree = "pQ";               // to divide the surfaces' triangles
constexpr double kLeastTetVolume = 1e-12;         // [mm^3] less is flat in double precision

/// A number in [-1, 1) that depends on its arguments only (splitmix64).
double hashed_unit(std::uint64_t index, std::uint64_t seed) {
  std::uint64_t z = (index + 1) * 0x9E3779B97F4A7C15ULL + seed * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  z ^= z >> 31;
  return double(z >> 11) * 0x1.0p-52 - 1.0;
}

std::vector<Vec3> jittered(const std::vector<Vec3>& points, double jitter, int seed) {
  // Coordinates around the origin keep TetGen's predicates sharp.
  Vec3 centre;
  for (const Vec3& p : points) centre += (1.0 / double(points.size())) * p;
  std::vector<Vec3> moved;
  moved.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto hash = [&](std::uint64_t axis) {
      return jitter * hashed_unit(3 * i + axis, std::uint64_t(seed));
    };
    moved.push_back(points[i] - centre + Vec3{hash(0), hash(1), hash(2)});
  }
  return moved;
}

struct Surfaces {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};
Surfaces surfaces_of(const TriangleMesh& inner, const GapBoundary& gap) {
  Surfaces both{inner.vertices, inner.triangles};
  both.vertices.insert(both.vertices.end(), gap.shell.vertices.begin(), gap.shell.vertices.end());
  const int offset = int(inner.vertices.size());
  for (const Triangle& t : gap.shell.triangles)
    both.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return both;
}

double volume_of(const Tet& t, const std::vector<Vec3>& x) {
  return tet_volume(x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])],
                    x[std::size_t(t[3])]);
}

/// Flips flat tets away, or fills what is around them anew: TetGen leaves them between vertices
/// that lie in a plane or on a circle, as those of a regular tube's neighbouring triangles and of a
/// cap do.
///
/// @return the number of those that are left
int mend_flat(std::vector<Tet>& tets, const std::vector<Vec3>& x) {
  const auto is_flat = [&](const Tet& t) { return !(volume_of(t, x) > kLeastTetVolume); };
  if (std::none_of(tets.begin(), tets.end(), is_flat)) return 0;
  TetTopology mesh(tets);
  const auto replace = [&](const int* old, int old_count, const Tet* fresh, int fresh_count) {
    std::vector<int> slots(std::size_t(fresh_count), 0);
    return fresh_count > 0 && mesh.replace(old, old_count, fresh, fresh_count, slots.data());
  };
  const auto flip = [&](int t) {
    const TetFlip best = best_flip(mesh, x, t);
    return replace(best.old.data(), best.old_count, best.fresh.data(), best.fresh_count);
  };
  const auto fill_anew = [&](int t) {
    const Refilling anew = refill_around(mesh, x, t);
    return replace(anew.old.data(), int(anew.old.size()), anew.fresh.data(),
                   int(anew.fresh.size()));
  };
  constexpr int kMostRounds = 8;  // a filling may have flat tets too
  bool changed = true;
  for (int round = 0; round < kMostRounds && changed; ++round) {
    changed = false;
    const int count = mesh.slot_count();
    for (int t = 0; t < count; ++t)
      if (mesh.alive(t) && is_flat(mesh.tet(t))) changed |= flip(t) || fill_anew(t);
  }
  tets = mesh.tets();
  return int(std::count_if(tets.begin(), tets.end(), is_flat));
}

struct Kept {
  std::vector<Tet> tets;
  int added_point_count = 0;   ///< tets left out because TetGen added one of their points
  int flat_count = 0;          ///< tets left out because they are flat
  bool flat_at_inner = false;  ///< is one of them at the inner surface?
};
Kept keep_positive(const TetrahedralizeResult& raw, const std::vector<Vec3>& vertices,
                   const std::vector<Vec3>& moved, int inner_count) {
  Kept kept;
  for (Tet t : raw.tets) {
    if (*std::max_element(t.begin(), t.end()) >= int(vertices.size())) {
      ++kept.added_point_count;
      continue;
    }
    if (volume_of(t, moved) < 0.0) std::swap(t[2], t[3]);
    kept.tets.push_back(t);
  }
  kept.flat_count = mend_flat(kept.tets, vertices);
  std::erase_if(kept.tets, [&](const Tet& t) {
    if (volume_of(t, vertices) > kLeastTetVolume) return false;
    for (const int v : t) kept.flat_at_inner = kept.flat_at_inner || v < inner_count;
    return true;
  });
  return kept;
}

TetMesh run_on_gap(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                   const Vec3& hole, const char* switches, double limit_s) {
  return run_tetgen({vertices, triangles, {hole}, {}, switches, "the gap between balloon and wall"},
                    limit_s);
}

// Nothing if TetGen fails; without tets if it needs more points than are worth following.
std::optional<TetMesh> try_gap_with_points(const Surfaces& surfaces, const Vec3& hole,
                                           const char* switches, double jitter, int seed) {
  constexpr double kLimit = 1.0;       // [s]; it takes a tenth
  constexpr double kMostPoints = 0.5;  // a surface vertex; with more it is too slow to follow
  std::vector<Vec3> with_hole = surfaces.vertices;
  with_hole.push_back(hole);
  std::vector<Vec3> moved = jittered(with_hole, jitter, seed);
  const Vec3 moved_hole = moved.back(), shift = moved_hole - hole;
  moved.pop_back();
  TetMesh mesh;
  try {
    mesh = run_on_gap(moved, surfaces.triangles, moved_hole, switches, kLimit);
  } catch (const InternalError&) {  // another attempt may do
    return std::nullopt;
  }
  if (mesh.vertices.size() < surfaces.vertices.size()) return std::nullopt;  // one is left out
  if (double(mesh.vertices.size()) > (1.0 + kMostPoints) * double(surfaces.vertices.size()))
    return TetMesh();
  for (Tet& t : mesh.tets)
    if (volume_of(t, mesh.vertices) < 0.0) std::swap(t[2], t[3]);
  if (!lift_off_surfaces(mesh, int(surfaces.vertices.size()))) return std::nullopt;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.vertices[v] =
        v < surfaces.vertices.size() ? surfaces.vertices[v] : mesh.vertices[v] - shift;
  mend_flat(mesh.tets, mesh.vertices);
  return mesh;
}

}  // namespace

TriangleMesh shaken(TriangleMesh surface) {
  constexpr double kBy = 1e-4;  // [mm]
  constexpr std::uint64_t kSeed = 77;
  for (std::size_t i = 0; i < surface.vertices.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      surface.vertices[i][axis] += kBy * hashed_unit(3 * i + std::uint64_t(axis), kSeed);
  return surface;
}

std::optional<Vec3> point_inside(const TriangleMesh& closed) {
  std::vector<Vec3> inwards = vertex_normals(closed);
  for (Vec3& n : inwards) n = -n;
  Vec3 low = closed.vertices.front(), high = low;
  for (const Vec3& p : closed.vertices)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  const std::vector<double> reach(closed.vertices.size(), distance(low, high));
  const std::vector<double> across = distances_ahead(closed, inwards, reach, Side::inside);
  const std::vector<double> entry = distances_ahead(closed, inwards, reach, Side::outside);
  double longest = 0.0;
  std::optional<Vec3> middle;
  for (std::size_t v = 0; v < inwards.size(); ++v) {
    // A way that meets the surface from outside first has not been inside.
    if (!(across[v] < entry[v]) || across[v] <= longest) continue;
    longest = across[v];
    middle = closed.vertices[v] + 0.5 * longest * inwards[v];
  }
  return middle;
}

TetrahedralizeResult tetrahedralize_gap(const std::vector<Vec3>& vertices,
                                        const std::vector<Triangle>& triangles, const Vec3& hole,
                                        double limit_s) {
  TetMesh mesh = run_on_gap(vertices, triangles, hole, kKeepingSurfaces, limit_s);
  return {std::move(mesh.tets), int(mesh.vertices.size()) - int(vertices.size())};
}

TetMesh mesh_gap_with_points(const TriangleMesh& inner, const GapBoundary& gap, const Vec3& hole) {
  // Where the surfaces touch, TetGen comes to no end with their triangles as they are; with leave
  // to divide them it does, at the cost of many points.
  struct Attempt {
    const char* switches;
    double jitter;  // [mm]
  };
  constexpr Attempt kAttempts[]{
      {kKeepingSurfaces, 0.0}, {kFree, 0.0}, {kKeepingSurfaces, 1e-4}, {kFree, 1e-4}};
  const Surfaces surfaces = surfaces_of(inner, gap);
  int seed = 0;
  for (const auto& [switches, jitter] : kAttempts) {
    const auto mesh = try_gap_with_points(surfaces, hole, switches, jitter, seed++);
    if (mesh) return *mesh;
  }
  return {};
}

TetMesh mesh_hollow(const std::vector<Vec3>& vertices, const std::vector<Triangle>& faces) {
  constexpr double kLimit = 1.0;          // [s]; it takes milliseconds
  constexpr std::size_t kMostPoints = 2;  // a vertex of the faces
  Vec3 centre;
  for (const Vec3& p : vertices) centre += (1.0 / double(vertices.size())) * p;
  std::vector<Vec3> moved;
  moved.reserve(vertices.size());
  for (const Vec3& p : vertices) moved.push_back(p - centre);
  TetMesh mesh;
  try {
    mesh = run_tetgen({moved, faces, {}, {}, kKeepingSurfaces, "a hollow of the air"}, kLimit);
  } catch (const InternalError&) {
    return {};
  }
  if (mesh.vertices.size() < vertices.size() ||
      mesh.vertices.size() > (1 + kMostPoints) * vertices.size())
    return {};
  for (Tet& t : mesh.tets)
    if (volume_of(t, mesh.vertices) < 0.0) std::swap(t[2], t[3]);
  mend_flat(mesh.tets, mesh.vertices);
  for (Vec3& p : mesh.vertices) p += centre;
  return mesh;
}

GapMesh mesh_gap(const TriangleMesh& inner, const GapBoundary& gap, const Vec3& hole) {
  auto [vertices, triangles] = surfaces_of(inner, gap);

  // The first jitter without added points wins; else the one with the fewest.
  Kept best;
  int fewest = -1;
  std::string failure;
  std::vector<Vec3> with_hole = vertices;
  with_hole.push_back(hole);
  for (int attempt = 0; attempt < kJitterAttempts && fewest != 0; ++attempt) {
    std::vector<Vec3> moved = jittered(with_hole, kJitters[std::size_t(attempt)], attempt);
    const Vec3 moved_hole = moved.back();
    moved.pop_back();
    try {
      Kept kept = keep_positive(tetrahedralize_gap(moved, triangles, moved_hole), vertices, moved,
                                int(inner.vertices.size()));
      if (fewest >= 0 && kept.added_point_count >= fewest) continue;
      fewest = kept.added_point_count;
      best = std::move(kept);
    } catch (const InternalError& error) {
      failure = error.what();
    }
  }
  if (fewest < 0) throw InternalError(failure);
  GapMesh result;
  result.tets.vertices = std::move(vertices);
  result.tets.tets = std::move(best.tets);
  result.flat_at_inner = best.flat_at_inner;
  if (best.added_point_count > 0)
    result.warnings.push_back(std::to_string(best.added_point_count) +
                              " air tetrahedra were left out because they need points beyond "
                              "those of balloon and wall");
  if (best.flat_count > 0)
    result.warnings.push_back(std::to_string(best.flat_count) +
                              " flat air tetrahedra were left out");
  return result;
}

}  // namespace angio::air_mesh
