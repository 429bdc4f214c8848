#pragma once

#include <optional>

#include "core/volume.hpp"
#include "meshing/wall_layers.hpp"

namespace angio::meshing {

/// From which brightness on plaque is calcified.
struct CalciumLevel {
  double lumen = 0.0;      ///< median intensity of the blood around
  double deviation = 0.0;  ///< its standard deviation there
  /// Calcium is brighter than all but 1 in 700 voxels of the blood beside it.
  [[nodiscard]] double threshold() const { return lumen + 3.0 * deviation; }
};

/// The blood's intensity in the box around a wall: of voxels that lie a voxel and more inside the
/// lumen, since contrast thins out along a tree. Deviation by the median of the distances from the
/// median (times 1.4826, of a normal distribution), which bright specks do not move.
///
/// @param level_set  signed distance to the lumen's boundary [mm], negative inside; on a grid of
/// its
///                   own around the lumen
/// @return nothing where there are fewer than 100 such voxels
std::optional<CalciumLevel> measure_calcium_level(const Volume<float>& scan,
                                                  const Volume<float>& level_set,
                                                  const WallLayers& wall);

/// Makes plaque and intima calcified where the scan is brighter than the blood, read at a wedge's
/// centre: in an X-ray image nothing else in a vessel's wall is. Media and adventitia are left:
/// what is bright there may be the bone beside the vessel.
///
/// @return the volume that has become calcified [mm^3]
double mark_calcium(const Volume<float>& scan, const CalciumLevel& level, WallLayers& wall);

}  // namespace angio::meshing
