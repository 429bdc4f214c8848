#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

#include "viewer/live.hpp"

namespace angio::viewer::window {

/// Steps a simulation on a thread of its own: no faster than real time, slower where it must. It
/// ends with this object, after the step under way.
class LiveSolver {
 public:
  /// @param drive  lives longer
  explicit LiveSolver(const LiveDrive& drive);
  ~LiveSolver();
  LiveSolver(const LiveSolver&) = delete;
  LiveSolver& operator=(const LiveSolver&) = delete;

  void set_aim(const LiveAim& aim);
  /// The last finished frame.
  [[nodiscard]] std::shared_ptr<const LiveState> latest() const;
  [[nodiscard]] int frame_count() const { return frame_count_; }
  [[nodiscard]] double busy_s() const { return busy_s_; }
  /// Throws what a step has thrown: it is the last then.
  void check() const;

 private:
  void work();

  const LiveDrive& drive_;
  mutable std::mutex mutex_;
  std::condition_variable wakes_;
  LiveAim aim_;
  std::shared_ptr<const LiveState> latest_;
  std::exception_ptr failure_;
  bool is_ending_ = false;
  std::atomic<int> frame_count_{0};
  std::atomic<double> busy_s_{0.0};
  std::thread thread_;  // the last: it uses all of these
};

}  // namespace angio::viewer::window
