#include "viewer/window/live_solver.hpp"

#include <chrono>

namespace angio::viewer::window {
namespace {
using Clock = std::chrono::steady_clock;
}  // namespace

LiveSolver::LiveSolver(const LiveDrive& drive)
    : drive_(drive),
      latest_(std::make_shared<LiveState>(drive.first)),
      thread_([this] { work(); }) {}

LiveSolver::~LiveSolver() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  wakes_.notify_all();
  thread_.join();
}

void LiveSolver::set_aim(const LiveAim& aim) {
  const std::lock_guard lock(mutex_);
  aim_ = aim;
}

std::shared_ptr<const LiveState> LiveSolver::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

void LiveSolver::check() const {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

void LiveSolver::work() {
  const auto pace =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(drive_.frame_s));
  Clock::time_point due = Clock::now();
  std::unique_lock lock(mutex_);
  while (!is_ending_) {
    const LiveAim aim = aim_;
    lock.unlock();
    const Clock::time_point begin = Clock::now();
    std::shared_ptr<const LiveState> state;
    std::exception_ptr failure;
    try {
      state = std::make_shared<LiveState>(drive_.step(aim));
    } catch (...) {
      failure = std::current_exception();
    }
    busy_s_ = busy_s_ + std::chrono::duration<double>(Clock::now() - begin).count();
    lock.lock();
    failure_ = failure;
    if (failure) return;
    latest_ = std::move(state);
    ++frame_count_;
    due = std::max(due + pace, Clock::now());  // what is late is not made up for
    wakes_.wait_until(lock, due, [this] { return is_ending_; });
  }
}

}  // namespace angio::viewer::window
