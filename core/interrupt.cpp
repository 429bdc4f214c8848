#include "core/interrupt.hpp"

#include <unistd.h>

#include <csignal>
#include <string_view>

#include "core/error.hpp"

namespace angio {
namespace {

constexpr int kPatienceSeconds = 1;

// Signal handlers can reach nothing else.
volatile std::sig_atomic_t stop_requested = 0;
volatile std::sig_atomic_t own_time = 0;

void request_stop(int) {
  if (stop_requested == 0 && own_time == 0) alarm(kPatienceSeconds);
  stop_requested = 1;
}

void end_now(int) {
  constexpr std::string_view kLine =
      "angio: interrupted. Run the same command again to go on; angio report CASE shows what is "
      "there\n";
  if (write(STDERR_FILENO, kLine.data(), kLine.size()) < 0) {
    // a closed or full standard error changes nothing
  }
  _exit(int(ExitCode::interrupted));
}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  sigaction(signal, &action, nullptr);
}

}  // namespace

void catch_interrupts() {
  handle(SIGALRM, end_now);
  handle(SIGINT, request_stop);
  handle(SIGTERM, request_stop);
  handle(SIGXFSZ, SIG_IGN);
  sigset_t ours;  // what starts this program may hold them back until now, so that none is lost
  sigemptyset(&ours);
  for (const int signal : {SIGALRM, SIGINT, SIGTERM}) sigaddset(&ours, signal);
  sigprocmask(SIG_UNBLOCK, &ours, nullptr);
}

void end_in_own_time() {
  own_time = 1;
  alarm(0);
}

void throw_if_interrupted() {
  if (stop_requested != 0) throw Interrupted();
}

}  // namespace angio
