#pragma once

#include "core/progress.hpp"
#include "reconstruction/detail/plane_frames.hpp"
#include "reconstruction/detail/voxel_projector.hpp"
#include "reconstruction/reconstruction.hpp"

namespace angio::reconstruction::detail {

/// The vessels of a few frames, on their planes.
struct VesselFrames {
  FrameStack pictures;                  ///< line integrals across the axis, without background
  std::vector<std::uint8_t> is_vessel;  ///< shape as `pictures.values`
  double noise = 0.0;                   ///< sd of a sample
};

/// Takes the vessels out of all frames of a run (detail/vessel_pictures.hpp).
VesselFrames read_vessel_frames(const RotationalRun& run, double air, const Orbit& orbit,
                                const PlaneGrid& plane, const Progress& progress);

/// The voxels that all frames but a tenth of them see as vessel (a visual hull: Laurentini, IEEE
/// Trans. Pattern Anal. Mach. Intell. 16:150, 1994). A frame that does not see a voxel says
/// nothing.
ChosenVoxels choose_voxels(const VesselFrames& frames, const ColumnGrid& grid);

/// What the iteration came to.
struct FewViews {
  std::vector<float> values;  ///< linear attenuation [1/mm], shape [voxels.count]
  int iterations = 0;
  bool has_converged = false;  ///< the last iteration changed it by under 1 % (root mean square)
  double residual = 0.0;       ///< of line integrals where vessels are, root mean square
};

/// Attenuation that is nowhere negative, from frames that are too few for filtered back-projection:
///
///     min over x >= 0:  1/2 sum (y - A x)^2 + s TV(x),     s = noise h sqrt(frames)
///
/// A: project(); TV: total_variation(); s: the sd of what the frames' noise leaves in a voxel when
/// it is projected back, h the edge of a voxel. Ordered subsets (Hudson, Larkin, IEEE Trans. Med.
/// Imaging 13:601, 1994) of frames that lie far apart: with each, one step along the subset's
/// gradient, each voxel's over (A'A 1), the separable surrogate's curvature (Erdogan, Fessler,
/// Phys. Med. Biol. 44:2835, 1999, eq. 17), then one of smooth_by_total_variation() with the mean
/// of the steps (as Sidky, Pan, Phys. Med. Biol. 53:4777, 2008 take turns).
///
/// It ends when an iteration, all subsets once, changes it by under 1 %, or after 40.
FewViews reconstruct_few_views(const VesselFrames& frames, const ChosenVoxels& voxels,
                               const Progress& progress);

/// Chosen voxels in their places, all others zero. @return shape [j_count, i_count, k_count]
std::vector<float> in_columns(const ChosenVoxels& voxels, const std::vector<float>& values);

}  // namespace angio::reconstruction::detail
