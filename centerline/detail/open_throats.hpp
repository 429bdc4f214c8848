#pragma once

#include "centerline/detail/surface_wall.hpp"
#include "core/volume.hpp"

namespace angio::centerline {

/// Opens the throats of a surface that its voxels have shut.
///
/// A lumen narrower than about two voxels falls between their centres, and what lies behind it
/// would have no line, though the surface is whole. The middles of the rays that cross such places
/// from wall to wall lie in the lumen: the voxels around them are taken in where a row of them
/// joins parts of the lumen that are apart otherwise, and where no wall lies between one middle and
/// the next. All else stays as it is: dents and folds that join nothing, and slits under a quarter
/// of a voxel high, through which vessels touch.
///
/// @param level_set  of voxelize(), with cubic voxels; voxels that are taken in get -1/4 voxel
/// @return the number of voxels that were taken in
int open_throats(Volume<float>& level_set, const SurfaceWall& wall);

}  // namespace angio::centerline
