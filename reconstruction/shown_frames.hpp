#pragma once

#include <vector>

#include "angiogram/cone_beam.hpp"
#include "core/volume.hpp"
#include "reconstruction/reconstruction.hpp"

namespace angio::reconstruction {

/// Some of a run's frames, small, to be looked at.
struct ShownFrames {
  std::vector<int> indices;                      ///< in the run, from 0
  std::vector<angiogram::ConeBeamFrame> frames;  ///< where their larger pixels lie
  Volume<float> pictures;  ///< line integrals, frame behind frame; spacing: on the detector [mm]
};

/// Eight of the frames that were used (all, of fewer), evenly from the first to the last; pixels
/// are the means of square blocks, so that no side is longer than 400.
///
/// @param run     as reconstruct_volume() takes it
/// @param result  what it gave: where the frames were, and what air is
ShownFrames show_frames(const RotationalRun& run, const Reconstruction& result);
/// @param places  where all frames were found to be
/// @param used    frames, from 0
/// @param air     RunQuality::unattenuated; of no matter where the run has masks
ShownFrames show_frames(const RotationalRun& run,
                        const std::vector<angiogram::ConeBeamFrame>& places,
                        const std::vector<int>& used, double air);

}  // namespace angio::reconstruction
