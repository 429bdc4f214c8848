#include <fcntl.h>
#include <sysexits.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "pipeline/cli/commands.hpp"

namespace {

/// Holds SIGINT and SIGTERM back until catch_interrupts(): one that comes while the libraries are
/// loaded would end the program without a word.
void hold_interrupts_back() {
  sigset_t ours;
  sigemptyset(&ours);
  sigaddset(&ours, SIGINT);
  sigaddset(&ours, SIGTERM);
  sigprocmask(SIG_BLOCK, &ours, nullptr);
}

/// OpenMP's threads spin while they wait, which on a machine that runs anything else beside this
/// program costs more than the waiting. libgomp reads the policy when it is loaded, before main,
/// so the program starts itself again with it; not for --version and --help, which do not compute.
void wait_without_spinning(int argc, char** argv, char** environment) {
  constexpr std::size_t kMost = 4096;
  constexpr std::string_view kName = "OMP_WAIT_POLICY=";
  static char policy[] = "OMP_WAIT_POLICY=passive";
  static std::array<char*, kMost> with_policy;
  if (argc < 2 || argv[1][0] == '-') return;
  std::size_t count = 0;
  for (; environment[count] != nullptr; ++count) {
    if (std::strncmp(environment[count], kName.data(), kName.size()) == 0) return;
    if (count + 2 >= kMost) return;  // then with spinning
    with_policy[count] = environment[count];
  }
  with_policy[count] = policy;
  execve("/proc/self/exe", argv, with_policy.data());  // returns only if it fails
}

/// The first of all that runs, before any library's own beginning.
void start_early(int argc, char** argv, char** environment) {
  hold_interrupts_back();
  wait_without_spinning(argc, argv, environment);
}

[[gnu::section(".preinit_array"), gnu::used]] void (*const kStartEarly)(int, char**,
                                                                        char**) = start_early;

/// What is opened first would otherwise take a closed stream's number, and be written into.
void open_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDWR) != stream) _exit(EX_IOERR);
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  return angio::pipeline::run_command_line(argc, argv);
}
