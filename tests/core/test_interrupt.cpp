#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"

namespace angio {
namespace {

struct End {
  int exit_code = -1;  ///< -1: a signal ended it
  double seconds = 0.0;
};

/// Runs `work` in a process that has caught its interrupts, and ends it by `signal` when it says
/// that it is ready.
End interrupt(int signal, const std::function<void(const std::function<void()>& ready)>& work) {
  int files[2];
  EXPECT_EQ(pipe(files), 0);
  const pid_t id = fork();
  if (id == 0) {
    catch_interrupts();
    try {
      work([&] {
        if (write(files[1], "x", 1) != 1) _exit(1);
      });
    } catch (const Interrupted&) {
      _exit(75);
    }
    _exit(0);
  }
  char letter = 0;
  EXPECT_EQ(read(files[0], &letter, 1), 1);
  const auto start = std::chrono::steady_clock::now();
  kill(id, signal);
  int status = 0;
  waitpid(id, &status, 0);
  close(files[0]);
  close(files[1]);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, elapsed.count()};
}

void sleep_on() {
  for (int i = 0; i < 300; ++i) usleep(100'000);  // a signal ends a single sleep
}

TEST(Interrupt, EndsWorkThatDoesNotListen) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const End end = interrupt(signal, [](const auto& ready) {
      ready();
      sleep_on();
    });
    EXPECT_EQ(end.exit_code, 75);
    EXPECT_LT(end.seconds, 15.0);  // 1 s on a machine that does nothing else; sleep_on takes 30
  }
}

TEST(Interrupt, IsHeardWhileAChildIsSilent) {
  const End end = interrupt(SIGTERM, [](const auto& ready) {
    end_in_own_time();  // so that it is heard, not ended
    ready();
    run_guarded(
        {}, [](ChildOutput&) { sleep_on(); }, [](ChildInput& input) { input.get(*new int); });
  });
  EXPECT_EQ(end.exit_code, 75);
  EXPECT_LT(end.seconds, 15.0);
}

TEST(Interrupt, WaitsForWhatEndsInItsOwnTime) {
  const End end = interrupt(SIGTERM, [](const auto& ready) {
    end_in_own_time();
    ready();
    for (int i = 0; i < 15; ++i) usleep(100'000);
  });
  EXPECT_EQ(end.exit_code, 0);
}

TEST(Interrupt, ComesThroughWhereItWasHeldBack) {
  const pid_t id = fork();
  if (id == 0) {
    sigset_t held;
    sigemptyset(&held);
    sigaddset(&held, SIGTERM);
    sigprocmask(SIG_BLOCK, &held, nullptr);
    std::raise(SIGTERM);
    catch_interrupts();
    try {
      throw_if_interrupted();
    } catch (const Interrupted&) {
      _exit(75);
    }
    _exit(0);
  }
  int status = 0;
  waitpid(id, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 75);
}

}  // namespace
}  // namespace angio
