#pragma once

#include <omp.h>

#include <future>
#include <utility>

namespace angio {

/// Work that goes on beside the caller, one piece at a time. Its parallel loops have as many
/// threads as the caller's; a caller with one thread does the work itself, at once, unless there is
/// one to spare.
class Beside {
 public:
  explicit Beside(bool has_spare_thread = false) : has_spare_thread_(has_spare_thread) {}

  /// Waits for the last piece, then starts this one.
  ///
  /// @throws what the last piece has thrown
  template <class Work>
  void run(Work work) {
    wait();
    const int threads = omp_get_max_threads();
    if (threads == 1 && !has_spare_thread_) return work();
    task_ = std::async(std::launch::async, [threads, work = std::move(work)]() mutable {
      omp_set_num_threads(threads);
      work();
    });
  }

  /// @throws what the last piece has thrown
  void wait() {
    if (task_.valid()) task_.get();
  }

 private:
  bool has_spare_thread_;
  std::future<void> task_;  // waits when it is destroyed
};

}  // namespace angio
