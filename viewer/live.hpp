#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "viewer/report.hpp"

namespace angio::viewer {

/// What a hand in the window asks for.
struct LiveAim {
  double pressure_atm = 0.0;  ///< above the outside
  double place_mm = 0.0;      ///< along the wire, from where the balloon was placed
};

/// What the window shows of a frame.
struct LiveState {
  Moment shape;  ///< its title is not used
  double time_s = 0.0;
  double pressure_atm = 0.0, volume_mm3 = 0.0, diameter_mm = 0.0;
  double place_mm = 0.0;
  bool is_stuck = false;  ///< the balloon cannot be pushed on
};

/// The simulation behind the window.
struct LiveDrive {
  LiveState first;
  double frame_s = 0.025;          ///< of simulated time that a step takes, > 0
  double most_pressure_atm = 8.0;  ///< > 0
  double rated_burst_atm = 0.0;    ///< 0: not known
  double least_place_mm = 0.0, most_place_mm = 0.0;
  /// One frame towards the aim; called on a thread of its own.
  std::function<LiveState(const LiveAim&)> step;
};

struct LiveOptions {
  int width = 1200;
  int height = 800;
  std::vector<std::string> keys;  ///< pressed at the start, by X's names
  double pressure_atm = 0.0;      ///< the aim at the start
  double seconds = 0.0;  ///< until the window closes by itself; 0: when the user does, or with a
                         ///< screenshot as soon as it is drawn
  std::filesystem::path screenshot;  ///< of the last picture; empty: none
};

/// How a session went.
struct LiveRates {
  double seconds = 0.0;
  int frame_count = 0, picture_count = 0;
  double busy_s = 0.0;  ///< in which the solver computed
  LiveState last;

  [[nodiscard]] double frames_per_second() const { return frame_count / seconds; }
  [[nodiscard]] double pictures_per_second() const { return picture_count / seconds; }
};

/// Opens a window on a case in which the balloon is inflated, let down and pushed along by slider
/// or keys, in real time where the solver is quick enough. Ctrl-C, SIGTERM and closing end it at
/// once.
/// @throws Error (69) if there is no display, (64) if a key is not known; what `step` throws
LiveRates show_live(const std::filesystem::path& case_folder, const LiveDrive& drive,
                    const LiveOptions& options);

}  // namespace angio::viewer
