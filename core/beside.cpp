#include "core/beside.hpp"

#include <omp.h>

#include <algorithm>
#include <system_error>
#include <utility>

namespace angio {

Beside::Beside(bool has_spare_thread, std::size_t most_waiting, int workers)
    : threads_(std::max(omp_get_max_threads() / workers, 1)),
      is_beside_(has_spare_thread || omp_get_max_threads() > 1),
      most_waiting_(most_waiting) {
  if (!is_beside_) return;
  try {
    for (int n = 0; n < workers; ++n) workers_.emplace_back([this] { work_on(); });
  } catch (const std::system_error&) {  // the system gives no more threads: as many as there are
    is_beside_ = !workers_.empty();
  }
}

Beside::~Beside() {
  if (!is_beside_) return;
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    waiting_.clear();
  }
  changed_.notify_all();
  for (std::thread& worker : workers_) worker.join();
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
  changed_.wait(lock, [&] { return failure_ || (waiting_.empty() && busy_count_ == 0); });
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
      ++busy_count_;
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
    --busy_count_;
    changed_.notify_all();
  }
}

}  // namespace angio
