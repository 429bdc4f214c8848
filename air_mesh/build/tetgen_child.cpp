#include "air_mesh/build/tetgen_child.hpp"

#ifndef TETLIBRARY
#define TETLIBRARY
#endif
#include <tetgen.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>

#include "core/child_process.hpp"
#include "core/error.hpp"

namespace angio::air_mesh {
namespace {

constexpr double kPatience = 20.0;  // with a child that a busy machine gives no time
constexpr std::size_t kMemory = std::size_t(16) << 30;  // far beyond what a vessel's mesh takes
constexpr int kNoMemory = 1;                            // what TetGen throws when it gets none

REAL* copy_points(const std::vector<Vec3>& points) {
  REAL* list = new REAL[3 * points.size()];
  for (std::size_t v = 0; v < points.size(); ++v)
    for (int axis = 0; axis < 3; ++axis) list[3 * v + std::size_t(axis)] = points[v][axis];
  return list;
}

/// Fills TetGen's input.
void fill(tetgenio& io, const TetgenInput& input) {
  io.firstnumber = 0;
  io.numberofpoints = int(input.vertices.size());
  io.pointlist = copy_points(input.vertices);
  if (!input.edge_lengths.empty()) {
    io.numberofpointmtrs = 1;
    io.pointmtrlist = new REAL[input.edge_lengths.size()];
    std::copy(input.edge_lengths.begin(), input.edge_lengths.end(), io.pointmtrlist);
  }
  io.numberoffacets = int(input.triangles.size());
  io.facetlist = new tetgenio::facet[input.triangles.size()];
  for (std::size_t t = 0; t < input.triangles.size(); ++t) {
    tetgenio::facet& facet = io.facetlist[t];
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    facet.numberofholes = 0;
    facet.holelist = nullptr;
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3];
    for (std::size_t c = 0; c < 3; ++c) facet.polygonlist[0].vertexlist[c] = input.triangles[t][c];
  }
  io.numberofholes = int(input.holes.size());
  if (!input.holes.empty()) io.holelist = copy_points(input.holes);
}

/// What the child does: TetGen, then point count, tet count, points and tets into the pipe.
void send_mesh(const TetgenInput& input, ChildOutput& output) {
  tetgenio in;
  tetgenio out;
  fill(in, input);
  std::string switches = input.switches;
  try {
    tetrahedralize(switches.data(), &in, &out);
  } catch (const int error) {
    if (error == kNoMemory) throw std::bad_alloc();
    throw;
  }
  output.put(std::array<int, 2>{out.numberofpoints, out.numberoftetrahedra});
  output.write(out.pointlist, 3 * std::size_t(out.numberofpoints) * sizeof(REAL));
  output.write(out.tetrahedronlist, 4 * std::size_t(out.numberoftetrahedra) * sizeof(int));
  output.flush();
  in.initialize();  // the arrays are given up: the child ends without cleaning
  out.initialize();
}

TetMesh receive_mesh(ChildInput& from, const std::string& what) {
  static_assert(sizeof(Vec3) == 3 * sizeof(REAL) && sizeof(Tet) == 4 * sizeof(int));
  std::array<int, 2> counts{};
  from.get(counts);
  if (counts[0] < 0 || counts[1] < 0) throw InternalError("TetGen gave no mesh of " + what);
  TetMesh mesh;
  mesh.vertices.resize(std::size_t(counts[0]));
  mesh.tets.resize(std::size_t(counts[1]));
  from.read(mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3));
  from.read(mesh.tets.data(), mesh.tets.size() * sizeof(Tet));
  return mesh;
}

std::string failure(const ChildResult& result, const std::string& what, double limit_s) {
  if (result.end == ChildEnd::timed_out)
    return "TetGen did not finish " + what + " in " + std::to_string(int(limit_s)) + " s";
  if (result.end == ChildEnd::out_of_memory) return "TetGen ran out of memory on " + what;
  if (result.signal != 0)
    return "TetGen crashed on " + what + " (signal " + std::to_string(result.signal) + ")";
  return "TetGen refused " + what;
}

}  // namespace

TetMesh run_tetgen(const TetgenInput& input, double limit_s) {
  // Of the processor: a mesh that is not had in time is not had on a busy machine either.
  const ChildLimits limits{kMemory, int(std::ceil(limit_s)), kPatience * limit_s};
  TetMesh mesh;
  const ChildResult result = run_guarded(
      limits, [&](ChildOutput& output) { send_mesh(input, output); },
      [&](ChildInput& from) { mesh = receive_mesh(from, input.what); });
  if (result.end != ChildEnd::done) throw InternalError(failure(result, input.what, limit_s));
  return mesh;
}

}  // namespace angio::air_mesh
