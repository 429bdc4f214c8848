#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace angio {

/// Work that goes on beside the caller, piece after piece in the given order, on a thread of its
/// own; or on several, which begin with pieces in that order and end in any. Its parallel loops
/// have as many threads as those of the caller that made it, together; where that is one, the
/// caller does the work itself, at once, unless there is a thread to spare. After a piece that
/// throws nothing is begun until the caller has been told. What waits when it is destroyed is
/// dropped.
class Beside {
 public:
  /// @param most_waiting  pieces that may wait for those before them, > 0
  /// @param workers  threads that work on them, > 0
  explicit Beside(bool has_spare_thread = false, std::size_t most_waiting = 1, int workers = 1);
  ~Beside();
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;

  /// Hands over a piece of work; waits while too many others do.
  ///
  /// @throws what an earlier piece has thrown
  void run(std::function<void()> work);

  /// Until all pieces are done.
  ///
  /// @throws what a piece has thrown
  void wait();

 private:
  void work_on();
  void throw_failure();

  int threads_;
  bool is_beside_;
  std::size_t most_waiting_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  int busy_count_ = 0;
  bool is_ending_ = false;
  std::exception_ptr failure_;
  std::vector<std::thread> workers_;  // last: they use the others
};

/// Does one piece beside the caller and the other here. Returns once both have ended, or the one
/// has thrown before the other was begun.
///
/// @param beside  nothing else waits there
/// @throws what a piece throws
template <class There, class Here>
void do_both(Beside& beside, const There& there, const Here& here) {
  beside.run([&there] { there(); });
  try {
    here();
  } catch (...) {
    try {
      beside.wait();
    } catch (...) {  // the other's is told
    }
    throw;
  }
  beside.wait();
}

}  // namespace angio
