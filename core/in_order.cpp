#include "core/in_order.hpp"

#include <utility>

namespace angio {

void InOrder::run(int number, std::function<void()> work) {
  const std::lock_guard lock(mutex_);
  if (is_broken_) return;
  early_.emplace(number, std::move(work));
  while (!early_.empty() && early_.begin()->first == next_) {
    const auto due = early_.extract(early_.begin());
    ++next_;
    try {
      due.mapped()();
    } catch (...) {
      is_broken_ = true;
      early_.clear();
      throw;
    }
  }
}

}  // namespace angio
