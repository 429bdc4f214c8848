#pragma once

#include "meshing/detail/remesh.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing::detail {

/// Measures an open surface.
///
/// The volume between the surface and the target's zero is the integral of the signed distance over
/// the surface, right to first order in the distance.
LumenQuality measure_quality(const SurfaceDraft& draft, const SurfaceTarget& target);

/// The volume inside, once the caps are there.
void set_volume(LumenQuality& quality, const TriangleMesh& capped);

}  // namespace angio::meshing::detail
