#pragma once

#include <string>
#include <vector>

#include "reconstruction/detail/orbit.hpp"
#include "reconstruction/reconstruction.hpp"

/// The frames in which the heart stands alike.
namespace angio::reconstruction::detail {

/// The part of its beat that is over at each time, from R waves; beats before the first and after
/// the last are as long as the median one.
/// @param r_waves  ascending, two or more
/// @return [0, 1)
std::vector<double> cardiac_phases(const std::vector<double>& times_s,
                                   const std::vector<double>& r_waves_s);

/// Frames whose phase is at most half of `width` from `middle`, around the circle.
std::vector<int> frames_of_phase(const std::vector<double>& phases, double middle, double width);

/// Which frames are taken, and why.
struct Gate {
  std::vector<int> frames;  ///< of the run, ascending; all: it is not gated
  GatingQuality quality;
  std::string warning;  ///< empty: none
};

/// By options.gating: whether the vessels move with the heart (by more than half a pixel, root mean
/// square, at an F ratio of 10 or more, or of 20 where R waves do not tell the rate), and if so,
/// the frames of the wanted phase.
///
/// `automatic` does not look for a beat where there are neither R waves nor steps of a degree: such
/// runs are of what stands still, and looking means to read all frames once more.
///
/// Phases are told by R waves, or where there are none by the signal's own beat, whose quietest
/// fifth is taken to lie where the wanted phase is.
/// @throws InputError  options.gating is `on`, but nothing tells phases
Gate gate_run(const RotationalRun& run, double air, const ReconstructionOptions& options,
              const Progress& progress);

/// A run of some of another's frames.
class GatedRun {
 public:
  /// @param run  stays alive; so do its pictures
  GatedRun(const RotationalRun& run, const std::vector<int>& frames);
  [[nodiscard]] const RotationalRun& run() const { return run_; }

 private:
  class Reader : public FrameReader {
   public:
    Reader(const FrameReader* all, std::vector<int> frames)
        : all_(all), frames_(std::move(frames)) {}
    [[nodiscard]] std::vector<float> read(int first, int count) const override;

   private:
    const FrameReader* all_;
    std::vector<int> frames_;
  };
  Reader pictures_, masks_;
  RotationalRun run_;
};

}  // namespace angio::reconstruction::detail
