#include "viewer/window/closing_signals.hpp"

namespace angio::viewer::window {
namespace {

volatile std::sig_atomic_t closing_asked = 0;  // a signal handler can reach nothing else

void ask_to_close(int) { closing_asked = 1; }

}  // namespace

ClosingSignals::ClosingSignals() {
  closing_asked = 0;
  struct sigaction action = {};
  action.sa_handler = ask_to_close;
  sigaction(SIGINT, &action, &interrupt_before_);
  sigaction(SIGTERM, &action, &terminate_before_);
}

ClosingSignals::~ClosingSignals() {
  sigaction(SIGINT, &interrupt_before_, nullptr);
  sigaction(SIGTERM, &terminate_before_, nullptr);
  closing_asked = 0;
}

bool ClosingSignals::has_come() { return closing_asked != 0; }

}  // namespace angio::viewer::window
