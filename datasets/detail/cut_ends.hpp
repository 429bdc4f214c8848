#pragma once

#include "core/triangle_mesh.hpp"
#include "datasets/detail/lumen_shape.hpp"

namespace angio::datasets::detail {

/// Cuts the closed surface of a lumen that goes on past its ends, and caps it flat. Vertices near a
/// cut are first drawn onto its rim, so that no thin triangles arise.
///
/// @param surface  closed, on the continued wall
TriangleMesh cut_ends(const LumenShape& shape, TriangleMesh surface);

}  // namespace angio::datasets::detail
