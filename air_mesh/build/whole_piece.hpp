#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {

/// Leaves of some triangles the largest connected piece with a smooth border: triangles with two
/// free edges go, and where triangles meet in a vertex only the smaller fan goes.
void make_whole(std::vector<Triangle>& triangles, std::size_t vertex_count);

}  // namespace angio::air_mesh
