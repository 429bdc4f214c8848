#pragma once

#include "meshing/detail/soup.hpp"

namespace angio::meshing::detail {

/// Splits the edges that are longer than 1.5 times the way straight across the lumen there, until
/// their parts are no longer than half of that width. The surface stays the same. A tube that was
/// drawn with rings at its ends only has no vertices between them: nothing could be measured or
/// meshed there. Done where a quarter of the wall or more has such edges.
Count split_long_edges(TriangleMesh& mesh);

}  // namespace angio::meshing::detail
