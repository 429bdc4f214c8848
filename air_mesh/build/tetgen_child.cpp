#include "air_mesh/build/tetgen_child.hpp"

#ifndef TETLIBRARY
#define TETLIBRARY
#endif
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tetgen.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>

#include "core/error.hpp"

namespace angio::air_mesh {
namespace {

constexpr double kPatience = 20.0;  // with a child that a busy machine gives no time

REAL* copy_points(const std::vector<Vec3>& points) {
  REAL* list = new REAL[3 * points.size()];
  for (std::size_t v = 0; v < points.size(); ++v)
    for (int axis = 0; axis < 3; ++axis) list[3 * v + std::size_t(axis)] = points[v][axis];
  return list;
}

/// Fills TetGen's input. Its arrays are given up to the child process, which ends without cleaning.
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

/// A failed assertion of TetGen's is a mesh that it did not make, which the parent says in its way.
void be_silent() {
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
}

/// What the child does: TetGen, then point count, tet count, points and tets into the pipe.
[[noreturn]] void run_child(int descriptor, const TetgenInput& input, double limit_s) {
  for (const int crash : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) signal(crash, SIG_DFL);
  alarm(600);  // never outlives a parent that died
  be_silent();
  // Of the processor: a mesh that is not had in time is not had on a busy machine either.
  const auto seconds = rlim_t(std::ceil(limit_s));
  const rlimit most_time{seconds, seconds + 1};  // the first ends it by SIGXCPU
  setrlimit(RLIMIT_CPU, &most_time);
  try {
    tetgenio in;
    tetgenio out;
    fill(in, input);
    std::string switches = input.switches;
    tetrahedralize(switches.data(), &in, &out);
    const std::array<int, 2> counts{out.numberofpoints, out.numberoftetrahedra};
    write_all(descriptor, counts.data(), sizeof counts);
    write_all(descriptor, out.pointlist, 3 * std::size_t(out.numberofpoints) * sizeof(REAL));
    write_all(descriptor, out.tetrahedronlist,
              4 * std::size_t(out.numberoftetrahedra) * sizeof(int));
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

TetMesh parse(const std::vector<char>& bytes, const std::string& what) {
  std::array<int, 2> counts{};
  if (bytes.size() < sizeof counts) throw InternalError("TetGen gave no mesh of " + what);
  std::memcpy(counts.data(), bytes.data(), sizeof counts);
  TetMesh mesh;
  const std::size_t point_bytes = std::size_t(std::max(0, counts[0])) * 3 * sizeof(REAL);
  const std::size_t tet_bytes = std::size_t(std::max(0, counts[1])) * sizeof(Tet);
  if (bytes.size() != sizeof counts + point_bytes + tet_bytes)
    throw InternalError("TetGen's mesh of " + what + " is incomplete");
  static_assert(sizeof(Vec3) == 3 * sizeof(REAL));
  mesh.vertices.resize(std::size_t(counts[0]));
  mesh.tets.resize(std::size_t(counts[1]));
  if (point_bytes > 0) std::memcpy(mesh.vertices.data(), bytes.data() + sizeof counts, point_bytes);
  if (tet_bytes > 0)
    std::memcpy(mesh.tets.data(), bytes.data() + sizeof counts + point_bytes, tet_bytes);
  return mesh;
}

}  // namespace

TetMesh run_tetgen(const TetgenInput& input, double limit_s) {
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
    run_child(ends[1], input, limit_s);
  }
  close(ends[1]);
  std::vector<char> bytes;
  const bool answered = read_all(ends[0], kPatience * limit_s, bytes);
  close(ends[0]);
  if (!answered) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!answered || (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU))
    throw InternalError("TetGen did not finish " + input.what + " in " +
                        std::to_string(int(limit_s)) + " s");
  if (WIFSIGNALED(status))
    throw InternalError("TetGen crashed on " + input.what + " (signal " +
                        std::to_string(WTERMSIG(status)) + ")");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw InternalError("TetGen refused " + input.what);
  return parse(bytes, input.what);
}

}  // namespace angio::air_mesh
