#pragma once

#include <vector>

#include "reconstruction/detail/orbit.hpp"
#include "reconstruction/detail/plane_frames.hpp"
#include "reconstruction/detail/volume_task.hpp"
#include "reconstruction/reconstruction.hpp"

namespace angio::reconstruction::detail {

/// What every frame sees around the axis.
struct Field {
  double radius = 0.0, low = 0.0, high = 0.0;  ///< [mm], along the axis from the isocentre
};

/// @param open  the part of each frame that sees
/// @throws InputError  no place is seen by every frame
Field common_field(const std::vector<angiogram::ConeBeamFrame>& frames, const Orbit& orbit,
                   const OpenField& open);

struct Grids {
  ColumnGrid columns;
  VolumeGeometry geometry;
};

/// Voxels over the field, in whole voxels around the isocentre.
Grids make_grids(const Orbit& orbit, const Field& field, const PlaneGrid& plane,
                 const ReconstructionOptions& options);

/// Voxels outside the field get the median of those inside.
void fill_outside(const ColumnGrid& columns, Volume<float>& volume);

/// From the median of the differences between neighbours along i: 0.6745 sqrt(2) sd of the noise.
double noise_of(const Volume<float>& volume);

}  // namespace angio::reconstruction::detail
