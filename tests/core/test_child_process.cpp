#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "core/atomic_file.hpp"
#include "core/child_process.hpp"
#include "core/error.hpp"
#include "testing/temporary_folder.hpp"

namespace angio {
namespace {
namespace fs = std::filesystem;

ChildResult run(const ChildLimits& limits, const std::function<void(ChildOutput&)>& work) {
  return run_guarded(limits, work, [](ChildInput& input) {
    int end = 0;
    input.get(end);
  });
}

using test::TemporaryFolder;

ProgramCall shell(const std::string& script) {
  ProgramCall call;
  call.file = "/bin/sh";
  call.arguments = {"-c", script};
  return call;
}

bool comes_true(const std::function<bool()>& condition) {
  for (int i = 0; i < 1000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// Neither running nor waiting for a parent to ask how it ended.
bool is_gone(pid_t id) {
  std::ifstream status("/proc/" + std::to_string(id) + "/stat");
  std::string number, name, state;
  return !(status >> number >> name >> state) || state == "Z";
}

/// Runs `act` in a process of the test's own, which is killed as soon as it has written a process
/// id into the pipe.
/// @return that id
pid_t kill_parent_of(const std::function<void(int pipe)>& act) {
  int files[2];
  EXPECT_EQ(pipe(files), 0);
  const pid_t parent = fork();
  if (parent == 0) {
    act(files[1]);
    _exit(0);
  }
  pid_t child = -1;
  EXPECT_EQ(read(files[0], &child, sizeof child), ssize_t(sizeof child));
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  close(files[0]);
  close(files[1]);
  return child;
}

TEST(GuardedChild, HandsOverWhatItFound) {
  std::vector<double> numbers;
  std::string text;
  const auto result = run_guarded(
      {},
      [](ChildOutput& output) {
        output.put(std::vector<double>(100000, 2.5));
        output.put(std::string("words"));
      },
      [&](ChildInput& input) {
        input.get(numbers);
        input.get(text);
      });
  EXPECT_EQ(result.end, ChildEnd::done);
  EXPECT_EQ(numbers, std::vector<double>(100000, 2.5));
  EXPECT_EQ(text, "words");
}

TEST(GuardedChild, OutlivesEveryEndOfTheChild) {
  const auto crashed = run({}, [](ChildOutput&) { std::raise(SIGSEGV); });
  EXPECT_EQ(crashed.end, ChildEnd::broke_down);
  EXPECT_EQ(crashed.signal, SIGSEGV);
  EXPECT_EQ(run({}, [](ChildOutput&) { std::abort(); }).signal, SIGABRT);
  EXPECT_EQ(run({}, [](ChildOutput&) { _exit(0); }).end, ChildEnd::broke_down);
  EXPECT_EQ(run({}, [](ChildOutput&) { throw 7; }).end, ChildEnd::broke_down);
  const auto refused = run({}, [](ChildOutput&) { throw InputError("no good"); });
  EXPECT_EQ(refused.end, ChildEnd::refused);
  EXPECT_EQ(refused.message, "no good");
}

#if !defined(__SANITIZE_ADDRESS__)  // whose children are not shut in
// In the sandbox it may not open a file that it was not given, nor write; unconfined it may.
TEST(GuardedChild, IsShutInUnlessItIsOurOwnWork) {
  const TemporaryFolder folder;
  for (const Confinement confinement : {Confinement::sandbox, Confinement::none}) {
    const std::filesystem::path file =
        folder / (confinement == Confinement::none ? "free" : "shut_in");
    ChildLimits limits;
    limits.confinement = confinement;
    run_guarded(
        limits, [&](ChildOutput&) { std::ofstream(file) << "text"; }, [](ChildInput&) {});
    EXPECT_EQ(std::filesystem::exists(file) && std::filesystem::file_size(file) > 0,
              confinement == Confinement::none);
  }
}
#endif

TEST(GuardedChild, StopsAChildThatHangs) {
  const ChildLimits asleep{std::size_t(1) << 28, 60, 1};
  EXPECT_EQ(run(asleep, [](ChildOutput&) { sleep(30); }).end, ChildEnd::timed_out);
  const ChildLimits busy{std::size_t(1) << 28, 1, 30};
  const auto spin = [](ChildOutput&) {
    volatile bool forever = true;
    while (forever) {
    }
  };
  EXPECT_EQ(run(busy, spin).end, ChildEnd::timed_out);
}

#if !defined(__SANITIZE_ADDRESS__)
TEST(GuardedChild, StopsAChildThatTakesTooMuchMemory) {
  const ChildLimits small{std::size_t(64) << 20, 60, 60};
  const auto take = [](ChildOutput& output) {
    output.put(std::vector<char>(std::size_t(1) << 30, 'x'));
  };
  EXPECT_EQ(run(small, take).end, ChildEnd::out_of_memory);
}
#endif

TEST(GuardedChild, EndsWhenTheParentGivesUp) {
  EXPECT_THROW(run_guarded(
                   {},
                   [](ChildOutput& output) {
                     for (;;) output.put(1);
                   },
                   [](ChildInput&) { throw Interrupted(); }),
               Interrupted);
}

TEST(GuardedChild, ACountThatNoMemoryHoldsIsNotBelieved) {
  std::vector<double> numbers;
  const auto result = run_guarded(
      {}, [](ChildOutput& output) { output.put(std::uint64_t(1) << 60); },
      [&](ChildInput& input) { input.get(numbers); });
  EXPECT_EQ(result.end, ChildEnd::broke_down);
}

TEST(GuardedChild, DiesWithItsParent) {
  const pid_t child = kill_parent_of([](int pipe) {
    run_guarded(
        {},
        [](ChildOutput& output) {
          output.put(getpid());
          output.flush();
          sleep(600);
        },
        [&](ChildInput& input) {
          pid_t own = -1;
          input.get(own);
          if (write(pipe, &own, sizeof own) > 0) input.get(own);
        });
  });
  EXPECT_TRUE(comes_true([&] { return is_gone(child); }));
}

TEST(GuardedChild, MayHaveAChildOfItsOwn) {
  const ChildLimits short_time{std::size_t(1) << 30, 60, 5.0};
  const auto answer = [](ChildOutput& output) { output.put(1); };
  const auto parent = run(short_time, [&](ChildOutput& output) {
    if (run({}, answer).end == ChildEnd::done) answer(output);
  });
  EXPECT_EQ(parent.end, ChildEnd::done);
}

TEST(GuardedChild, AnotherThreadsChildHoldsNoPipeOpen) {
  std::vector<std::thread> threads;
  std::vector<ChildEnd> ends(64, ChildEnd::done);
  for (std::size_t t = 0; t < ends.size(); ++t)
    threads.emplace_back([&ends, t] {
      // Odd ones live on; the pipe of even ones must tell at once that they died.
      const ChildLimits limits{std::size_t(1) << 30, 60, t % 2 == 0 ? 60.0 : 3.0};
      ends[t] = run(limits, [t](ChildOutput&) {
                  if (t % 2 == 1) sleep(30);
                  _exit(0);
                }).end;
    });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t t = 0; t < ends.size(); ++t)
    EXPECT_EQ(ends[t], t % 2 == 0 ? ChildEnd::broke_down : ChildEnd::timed_out);
}

TEST(ChildProgram, PrintsIntoItsLog) {
  const TemporaryFolder folder;
  ProgramCall call = shell("echo one; echo two >&2; test ! -s /dev/stdin");
  call.log = folder / "log";
  ChildProgram program(call);
  ASSERT_TRUE(comes_true([&] { return program.result().has_value(); }));
  EXPECT_EQ(program.result()->end, ChildEnd::done);
  EXPECT_EQ(read_text(folder / "log"), "one\ntwo\n");
}

TEST(ChildProgram, WritesLines) {
  const ChildProgram program(shell("echo first >&3; echo second >&3; sleep 600"));
  EXPECT_EQ(program.read_line(10'000), "first");
  EXPECT_EQ(program.read_line(10'000), "second");
  EXPECT_EQ(program.read_line(1), "");
}

TEST(ChildProgram, ItsEndIsTold) {
  ChildProgram failed(shell("exit 7"));
  ASSERT_TRUE(comes_true([&] { return failed.result().has_value(); }));
  EXPECT_EQ(failed.result()->end, ChildEnd::broke_down);
  EXPECT_EQ(failed.result()->exit_status, 7);
  ChildProgram crashed(shell("kill -SEGV $$"));
  ASSERT_TRUE(comes_true([&] { return crashed.result().has_value(); }));
  EXPECT_EQ(crashed.result()->signal, SIGSEGV);
}

TEST(ChildProgram, ThatDoesNotExistIsRefused) {
  ProgramCall call;
  call.file = "/no/such/program";
  EXPECT_THROW(ChildProgram{call}, IoError);
  EXPECT_TRUE(waitpid(-1, nullptr, WNOHANG) < 0 && errno == ECHILD);
}

TEST(ChildProgram, RemovesItsTemporaryFilesWhenItIsAskedToEnd) {
  const TemporaryFolder folder;
  const std::string file = (folder / "lock").string();
  ProgramCall call = shell("trap 'rm -f " + file + "; exit 0' TERM; : > " + file +
                           "; echo ready >&3; while :; do sleep 0.05; done");
  {
    const ChildProgram program(call);
    EXPECT_EQ(program.read_line(10'000), "ready");
    EXPECT_TRUE(fs::exists(file));
  }
  EXPECT_FALSE(fs::exists(file));
}

TEST(ChildProgram, RemovesItsTemporaryFilesWhenItsParentIsKilled) {
  const TemporaryFolder folder;
  const std::string file = (folder / "lock").string();
  kill_parent_of([&](int pipe) {
    const ChildProgram program(shell("trap 'rm -f " + file + "; exit 0' TERM; : > " + file +
                                     "; echo ready >&3; while :; do sleep 0.05; done"));
    const pid_t unknown = program.read_line(10'000) == "ready" ? 1 : -1;
    if (write(pipe, &unknown, sizeof unknown) > 0) sleep(600);
  });
  EXPECT_TRUE(comes_true([&] { return !fs::exists(file); }));
}

TEST(ChildProgram, ThatWillNotEndIsKilled) {
  ChildProgram program(shell("trap '' TERM; echo ready >&3; while :; do sleep 0.05; done"));
  EXPECT_EQ(program.read_line(10'000), "ready");
  EXPECT_EQ(program.end(100).signal, SIGKILL);
}

}  // namespace
}  // namespace angio
