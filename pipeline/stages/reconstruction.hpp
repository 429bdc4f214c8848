#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "angiogram/cone_beam.hpp"
#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_work.hpp"
#include "reconstruction/reconstruction.hpp"
#include "reconstruction/shown_frames.hpp"
#include "segmentation/read_run.hpp"

namespace angio::pipeline {

/// From the frames of a rotational run to a volume.
void do_reconstruction(StageWork& work, const ReconstructionSettings& settings);

/// A run as the reconstruction takes it, but its pictures.
/// @param geometry  where the frames were taken, in a file; empty: where the header says
/// @throws InputError  the file is damaged, or has another number of frames
reconstruction::RotationalRun rotational_run(const segmentation::LoadedRun& loaded,
                                             const std::filesystem::path& geometry,
                                             std::vector<std::string>& warnings);

/// The frames of a run where its header says that they were taken.
std::vector<angiogram::ConeBeamFrame> frames_by_header(const segmentation::LoadedRun& loaded);

/// What shutter and collimator leave open, as the header has it.
std::optional<reconstruction::OpenField> open_field_of(const segmentation::LoadedRun& loaded);

/// Frames to be looked at, and where they see what.
void write_shown_frames(const std::filesystem::path& out, const reconstruction::ShownFrames& shown,
                        bool is_subtracted);

/// @return [s]
std::vector<double> in_seconds(std::vector<double> times_ms);

}  // namespace angio::pipeline
