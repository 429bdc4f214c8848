#pragma once

#include "centerline/detail/surface_wall.hpp"
#include "core/volume.hpp"

namespace angio::centerline {

/// Opens the throats of a surface that its voxels have shut.
///
/// A lumen narrower than about two voxels falls between their centres, and what lies behind it
/// would have no line, though the surface is whole. The middles of the rays that cross such places
/// from wall to wall (0.25 to 2.5 voxels apart) lie in the lumen: the voxels around them are taken
/// in where a row of them, and of crumbs between them (parts of fewer than 30 voxels), joins larger
/// parts of the lumen that are not linked otherwise, where no wall lies between one middle and the
/// next, and where no voxel would be linked through a wall to a part that the row does not lead to:
/// beside another vessel a throat stays shut. All else stays as it is: what joins nothing, and what
/// is narrower than a quarter of a voxel, as where vessels touch. Of a row all middles are taken in
/// that hang together, dents beside it too.
///
/// @param level_set  of voxelize(), with cubic voxels; voxels that are taken in get -1/4 voxel
/// @param wall       the surface that was voxelized
/// @param least_mm   what is narrower stays shut
/// @return the number of voxels that were taken in
int open_throats(Volume<float>& level_set, const SurfaceWall& wall, double least_mm = 0.0);

}  // namespace angio::centerline
