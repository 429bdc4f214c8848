#pragma once

#include <functional>
#include <string_view>
#include <utility>

namespace angio {

/// Tells the caller how far a stage is, and lets the caller stop it: the sink may throw
/// Interrupted. A default-constructed Progress is silent.
class Progress {
 public:
  using Sink = std::function<void(double fraction, std::string_view step)>;

  Progress() = default;
  explicit Progress(Sink sink) : sink_(std::move(sink)) {}

  /// @param fraction  of this stage, in [0, 1], never falling
  /// @param step      what is being done, for people; may be empty
  void report(double fraction, std::string_view step = {}) const {
    if (sink_) sink_(fraction, step);
  }

 private:
  Sink sink_;
};

/// The progress of a part of a stage, as [first, last] of the whole, which must outlive it.
inline Progress part(const Progress& whole, double first, double last) {
  return Progress([&whole, first, last](double fraction, std::string_view step) {
    whole.report(first + (last - first) * fraction, step);
  });
}

}  // namespace angio
