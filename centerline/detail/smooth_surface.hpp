#pragma once

#include "core/triangle_mesh.hpp"

namespace angio::centerline {

/// How rough a surface is: the median distance by which a vertex's step to the middle of its
/// neighbours differs from theirs, in mean edge lengths. Below 0.05 on smooth surfaces, whatever
/// their curvature; above 0.1 where vertices are noisy or stand on a staircase of voxels.
double roughness(const TriangleMesh& mesh);

/// Takes off the noise of vertices and keeps the volume.
///
/// Source: Taubin, "A signal processing approach to fair surface design", SIGGRAPH 1995,
///         doi:10.1145/218380.218473: steps of +0.5 and -0.53 in turn.
/// Only to find out where the lumen is: what is measured are the vertices as they came.
void smooth_surface(TriangleMesh& mesh, int rounds);

}  // namespace angio::centerline
