#include "meshing/detail/air_mesh.hpp"

#ifndef TETLIBRARY
#define TETLIBRARY
#endif
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <tetgen.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>

#include "core/error.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kJitter = 1e-4;           // [mm]
constexpr int kJitterAttempts = 6;         // with other jitters
constexpr double kLeastTetVolume = 1e-12;  // [mm^3] less is flat in double precision

/// A number in [-1, 1) that depends on its arguments only (splitmix64).
double hashed_unit(std::uint64_t index, std::uint64_t seed) {
  std::uint64_t z = (index + 1) * 0x9E3779B97F4A7C15ULL + seed * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  z ^= z >> 31;
  return double(z >> 11) * 0x1.0p-52 - 1.0;
}

std::vector<Vec3> jittered(const std::vector<Vec3>& points, int attempt) {
  // Coordinates around the origin keep TetGen's predicates sharp.
  Vec3 centre;
  for (const Vec3& p : points) centre += (1.0 / double(points.size())) * p;
  std::vector<Vec3> moved;
  moved.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto hash = [&](std::uint64_t axis) {
      return kJitter * hashed_unit(3 * i + axis, std::uint64_t(attempt));
    };
    moved.push_back(points[i] - centre + Vec3{hash(0), hash(1), hash(2)});
  }
  return moved;
}

/// Fills TetGen's input. Its arrays are given up to the child process, which ends without cleaning.
void fill_input(tetgenio& input, const std::vector<Vec3>& vertices,
                const std::vector<Triangle>& triangles, const Vec3& hole) {
  input.numberofpoints = int(vertices.size());
  input.pointlist = new REAL[3 * vertices.size()];
  for (std::size_t v = 0; v < vertices.size(); ++v)
    for (int axis = 0; axis < 3; ++axis)
      input.pointlist[3 * v + std::size_t(axis)] = vertices[v][axis];
  input.numberoffacets = int(triangles.size());
  input.facetlist = new tetgenio::facet[triangles.size()];
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    tetgenio::facet& facet = input.facetlist[t];
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    facet.numberofholes = 0;
    facet.holelist = nullptr;
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3];
    for (std::size_t c = 0; c < 3; ++c) facet.polygonlist[0].vertexlist[c] = triangles[t][c];
  }
  input.numberofholes = 1;
  input.holelist = new REAL[3];
  for (int axis = 0; axis < 3; ++axis) input.holelist[axis] = hole[axis];
}

void write_all(int descriptor, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = write(descriptor, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) _exit(4);
    at += written;
    size -= std::size_t(written);
  }
}

/// What the child does: TetGen, then point count, tet count and tets into the pipe.
[[noreturn]] void run_child(int descriptor, const std::vector<Vec3>& vertices,
                            const std::vector<Triangle>& triangles, const Vec3& hole) {
  for (const int crash : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) signal(crash, SIG_DFL);
  alarm(600);  // never outlives a parent that died
  try {
    tetgenio input;
    tetgenio output;
    input.firstnumber = 0;
    fill_input(input, vertices, triangles, hole);
    char switches[] = "pYYQ";
    tetrahedralize(switches, &input, &output);
    const std::array<int, 2> counts{output.numberofpoints, output.numberoftetrahedra};
    write_all(descriptor, counts.data(), sizeof counts);
    write_all(descriptor, output.tetrahedronlist,
              4 * std::size_t(output.numberoftetrahedra) * sizeof(int));
    _exit(0);
  } catch (...) {
    _exit(3);
  }
}

/// Reads until the other side closes; false when time is up.
bool read_all(int descriptor, double limit_s, std::vector<char>& bytes) {
  const auto start = std::chrono::steady_clock::now();
  std::array<char, 65536> buffer{};
  while (true) {
    const double used =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (used > limit_s) return false;
    pollfd wait{descriptor, POLLIN, 0};
    const int ready = poll(&wait, 1, int(1000.0 * std::min(limit_s - used, 10.0)) + 1);
    if (ready < 0 && errno != EINTR) return false;
    if (ready <= 0) continue;
    const ssize_t count = read(descriptor, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    if (count == 0) return true;
    bytes.insert(bytes.end(), buffer.data(), buffer.data() + count);
  }
}

TetrahedralizeResult parse(const std::vector<char>& bytes, std::size_t vertex_count) {
  std::array<int, 2> counts{};
  if (bytes.size() < sizeof counts) throw InternalError("TetGen gave no mesh of the gap");
  std::memcpy(counts.data(), bytes.data(), sizeof counts);
  const auto size = std::size_t(counts[1]) * sizeof(std::array<int, 4>);
  if (counts[1] < 0 || bytes.size() != sizeof counts + size)
    throw InternalError("TetGen's mesh of the gap is incomplete");
  TetrahedralizeResult result;
  result.tets.resize(std::size_t(counts[1]));
  if (size > 0) std::memcpy(result.tets.data(), bytes.data() + sizeof counts, size);
  result.added_vertex_count = counts[0] - int(vertex_count);
  return result;
}

/// Keeps tets over known vertices with positive volume in the true coordinates.
struct Kept {
  std::vector<Tet> tets;
  int added_point_count = 0;  ///< tets left out because TetGen added one of their points
  int flat_count = 0;         ///< tets left out because they are flat
};
Kept keep_positive(const TetrahedralizeResult& raw, const std::vector<Vec3>& vertices,
                   const std::vector<Vec3>& moved) {
  Kept kept;
  for (Tet t : raw.tets) {
    if (*std::max_element(t.begin(), t.end()) >= int(vertices.size())) {
      ++kept.added_point_count;
      continue;
    }
    const auto volume = [&](const std::vector<Vec3>& x) {
      return tet_volume(x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])],
                        x[std::size_t(t[3])]);
    };
    if (volume(moved) < 0.0) std::swap(t[2], t[3]);
    if (volume(vertices) > kLeastTetVolume)
      kept.tets.push_back(t);
    else
      ++kept.flat_count;
  }
  return kept;
}

}  // namespace

std::optional<GapBoundary> close_region(const TriangleMesh& region) {
  GapBoundary gap{region, int(region.triangles.size())};
  for (const std::vector<int>& loop : boundary_loops(region)) {
    std::vector<Vec3> points;
    for (const int v : loop) points.push_back(region.vertices[std::size_t(v)]);
    const std::vector<Triangle> patch = triangulate_loop(points);
    if (patch.empty()) return std::nullopt;
    for (const Triangle& t : patch)
      gap.shell.triangles.push_back(
          {loop[std::size_t(t[0])], loop[std::size_t(t[1])], loop[std::size_t(t[2])]});
  }
  return gap;
}

TetrahedralizeResult tetrahedralize_gap(const std::vector<Vec3>& vertices,
                                        const std::vector<Triangle>& triangles, const Vec3& hole,
                                        double limit_s) {
  int ends[2];
  if (pipe(ends) != 0) throw InternalError("no pipe to TetGen could be opened");
  const pid_t child = fork();
  if (child < 0) {
    close(ends[0]);
    close(ends[1]);
    throw InternalError("no process for TetGen could be started (too little memory?)");
  }
  if (child == 0) {
    close(ends[0]);
    run_child(ends[1], vertices, triangles, hole);
  }
  close(ends[1]);
  std::vector<char> bytes;
  const bool in_time = read_all(ends[0], limit_s, bytes);
  close(ends[0]);
  if (!in_time) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!in_time)
    throw InternalError("TetGen did not finish the gap between balloon and wall in " +
                        std::to_string(int(limit_s)) + " s");
  if (WIFSIGNALED(status))
    throw InternalError("TetGen crashed on the gap between balloon and wall (signal " +
                        std::to_string(WTERMSIG(status)) + ")");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw InternalError("TetGen refused the gap between balloon and wall");
  return parse(bytes, vertices.size());
}

GapMesh mesh_gap(const TriangleMesh& inner, const GapBoundary& gap, const Vec3& hole) {
  std::vector<Vec3> vertices = inner.vertices;
  vertices.insert(vertices.end(), gap.shell.vertices.begin(), gap.shell.vertices.end());
  std::vector<Triangle> triangles = inner.triangles;
  const int offset = int(inner.vertices.size());
  for (const Triangle& t : gap.shell.triangles)
    triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});

  // The first jitter without added points and flat tets wins; else the one with the fewest.
  Kept best;
  int best_faults = -1;
  std::string failure;
  std::vector<Vec3> with_hole = vertices;
  with_hole.push_back(hole);
  for (int attempt = 0; attempt < kJitterAttempts && best_faults != 0; ++attempt) {
    std::vector<Vec3> moved = jittered(with_hole, attempt);
    const Vec3 moved_hole = moved.back();
    moved.pop_back();
    try {
      Kept kept = keep_positive(tetrahedralize_gap(moved, triangles, moved_hole), vertices, moved);
      const int faults = 1000 * kept.added_point_count + kept.flat_count;
      if (best_faults >= 0 && faults >= best_faults) continue;
      best_faults = faults;
      best = std::move(kept);
    } catch (const InternalError& error) {
      failure = error.what();
    }
  }
  if (best_faults < 0) throw InternalError(failure);
  GapMesh result;
  result.tets.vertices = std::move(vertices);
  result.tets.tets = std::move(best.tets);
  if (best.added_point_count > 0)
    result.warnings.push_back(std::to_string(best.added_point_count) +
                              " air tetrahedra were left out because they need points beyond "
                              "those of balloon and wall");
  if (best.flat_count > 0)
    result.warnings.push_back(std::to_string(best.flat_count) +
                              " flat air tetrahedra were left out");
  return result;
}

}  // namespace angio::meshing::detail
