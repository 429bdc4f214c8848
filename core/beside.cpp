#include "core/beside.hpp"

#include <omp.h>

#include <utility>

namespace angio {

Beside::Beside(bool has_spare_thread, std::size_t most_waiting)
    : threads_(omp_get_max_threads()),
      is_beside_(has_spare_thread || threads_ > 1),
      most_waiting_(most_waiting) {
  if (is_beside_) thread_ = std::thread([this] { work_on(); });
}

Beside::~Beside() {
  if (!is_beside_) return;
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    waiting_.clear();
  }
  changed_.notify_all();
  thread_.join();
}

void Beside::run(std::function<void()> work) {
  if (!is_beside_) return work();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ || waiting_.size() < most_waiting_; });
  throw_failure();
  waiting_.push_back(std::move(work));
  lock.unlock();
  changed_.notify_all();
}

void Beside::wait() {
  if (!is_beside_) return;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ || (waiting_.empty() && !is_busy_); });
  throw_failure();
}

// Once: the caller that has seen it goes on without.
void Beside::throw_failure() {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void Beside::work_on() {
  omp_set_num_threads(threads_);
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return is_ending_ || !waiting_.empty(); });
    if (is_ending_) return;
    {
      const std::function<void()> work = std::move(waiting_.front());
      waiting_.pop_front();
      is_busy_ = true;
      lock.unlock();
      changed_.notify_all();
      std::exception_ptr failure;
      try {
        work();
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      if (failure) {
        failure_ = failure;
        waiting_.clear();
      }
    }
    is_busy_ = false;
    changed_.notify_all();
  }
}

}  // namespace angio
