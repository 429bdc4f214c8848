#pragma once

#include <functional>
#include <map>
#include <mutex>

namespace angio {

/// Work of numbered pieces, done in the order of their numbers, 0, 1, 2, ..., whichever comes
/// first and from whatever thread: one that comes early is left for the thread that brings the last
/// one before it. One piece is done at a time; after one that throws none is done.
class InOrder {
 public:
  /// @param number  each number once
  /// @throws what a piece throws
  void run(int number, std::function<void()> work);

 private:
  std::mutex mutex_;
  std::map<int, std::function<void()>> early_;
  int next_ = 0;
  bool is_broken_ = false;
};

}  // namespace angio
