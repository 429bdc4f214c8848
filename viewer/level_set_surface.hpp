#pragma once

#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"

namespace angio::viewer {

/// The zero of a level set as it is looked at: VTK's contour, straight between voxels. (What is
/// simulated is the stage meshing's.)
///
/// @param level_set  negative inside [mm]
/// @return open where the zero leaves the volume; empty where there is none
TriangleMesh zero_surface(const Volume<float>& level_set);

}  // namespace angio::viewer
