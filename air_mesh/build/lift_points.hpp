#pragma once

#include "core/tet_mesh.hpp"

namespace angio::air_mesh {

/// Gives a mesh of a gap its surfaces back where TetGen split one of their edges or triangles: the
/// added point goes a little into the gap, and new tets lie between it and the surface's own
/// triangles.
///
/// A point p on a surface sees all of its star but the faces in its own plane(s), from which every
/// step along the sum of their normals leads away. So there is such a step for every point.
/// @param surface_count  vertices of the surfaces, which come first; the others were added
/// @return false, with the mesh in any state, if a place cannot be read
bool lift_off_surfaces(TetMesh& mesh, int surface_count);

}  // namespace angio::air_mesh
