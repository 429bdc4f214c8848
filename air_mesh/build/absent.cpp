#include "air_mesh/build/build_air.hpp"
#include "core/error.hpp"

// In place of the other sources of this folder where CGAL or TetGen is missing.
namespace angio::air_mesh {

bool can_build_air() { return false; }

namespace {
[[noreturn]] void refuse() {
  throw Error(ExitCode::unavailable,
              "an air mesh was to be built, but this program was compiled without CGAL and TetGen. "
              "Compile it where they are installed (docs/dependencies.md)");
}
}  // namespace

TetMesh build_air(const TriangleMesh&, const TriangleMesh&) { refuse(); }
TetMesh mesh_hollow(const std::vector<Vec3>&, const std::vector<Triangle>&) { refuse(); }

}  // namespace angio::air_mesh
