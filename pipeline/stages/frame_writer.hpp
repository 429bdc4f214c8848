#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "core/beside.hpp"
#include "formats/files.hpp"
#include "pipeline/stages/treated_lumen.hpp"
#include "simulation/simulation.hpp"

namespace angio::pipeline {

using SharedFrame = std::shared_ptr<const simulation::SimulationFrame>;

inline SharedFrame share(const simulation::SimulationFrame& frame) {
  return std::make_shared<const simulation::SimulationFrame>(frame);
}

/// The two frames of a run that its result is of. At least one has been added.
class PeakAndLast {
 public:
  void add(SharedFrame frame);
  [[nodiscard]] const simulation::SimulationFrame& peak() const { return *peak_; }
  [[nodiscard]] const simulation::SimulationFrame& last() const { return *last_; }
  [[nodiscard]] std::vector<SharedFrame> both() const { return {peak_, last_}; }

 private:
  SharedFrame peak_, last_;
};

/// The balloon in a frame's lumen. One that touches the wall nowhere is narrower: it need not be
/// seen.
std::vector<Vec3> balloon_in_lumen(const simulation::SimulationFrame& frame);

/// Writes and measures a run's frames as they come: every n-th, and in the end the peak and the
/// last. Files are written by as many threads as the caller has; one more measures the lumen.
class FrameWriter {
 public:
  FrameWriter(std::filesystem::path folder, const simulation::SimulationModel& model,
              const TreatedLumen& lumen, int write_every);

  void add(const simulation::SimulationFrame& frame);
  void finish();

  [[nodiscard]] const PeakAndLast& kept() const { return kept_; }
  /// The largest while the balloon is inflated and held [%]; NaN where its ends are not watched.
  [[nodiscard]] double most_dogboning_percent() const;

 private:
  /// The list of frames and the time series, as far as the last written frame. They are written
  /// now and then, so that the viewer can follow the run.
  void write_tables();
  void write(const SharedFrame& frame);
  /// Of a measured frame as it is; between two of them by the straight line in time.
  [[nodiscard]] double lumen_mld(int frame) const;

  std::filesystem::path folder_;
  const simulation::SimulationModel& model_;
  const TreatedLumen& lumen_;
  TreatedLumen::LesionFollower follower_;
  int write_every_;
  std::vector<simulation::SimulationFrame> rows_;  ///< without their shapes
  std::map<int, double> mld_;                      ///< of the frames that are measured [mm]
  std::set<int> written_;
  std::vector<formats::TimeStep> steps_;
  PeakAndLast kept_;
  std::chrono::steady_clock::time_point last_tables_ = {};
  Beside measuring_, writing_;  // last: they use the others
};

}  // namespace angio::pipeline
