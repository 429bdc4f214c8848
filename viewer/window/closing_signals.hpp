#pragma once

#include <csignal>

namespace angio::viewer::window {

/// While it lives, Ctrl-C (SIGINT) and SIGTERM only leave a note, which the window reads at every
/// tick of its clock; what they did before comes back afterwards. One at a time.
class ClosingSignals {
 public:
  ClosingSignals();
  ~ClosingSignals();
  ClosingSignals(const ClosingSignals&) = delete;
  ClosingSignals& operator=(const ClosingSignals&) = delete;

  [[nodiscard]] static bool has_come();

 private:
  struct sigaction interrupt_before_ = {}, terminate_before_ = {};
};

}  // namespace angio::viewer::window
