#include "air_mesh/build/build_air.hpp"
#include "core/error.hpp"

// In place of the other sources of this folder where CGAL or TetGen is missing.
namespace angio::air_mesh {

bool can_build_air() { return false; }

TetMesh build_air(const TriangleMesh&, const TriangleMesh&) {
  throw Error(ExitCode::unavailable,
              "an air mesh was to be built, but this program was compiled without CGAL and TetGen. "
              "Compile it where they are installed (docs/dependencies.md)");
}

}  // namespace angio::air_mesh
