#include <fcntl.h>
#include <sysexits.h>
#include <unistd.h>

#include <algorithm>
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

/// What libraries read of the environment when they are loaded, before main.
/// OpenMP's threads spin while they wait, which on a machine that runs anything else beside this
/// program costs more than the waiting. glibc gives each large block back to the system and gets it
/// anew, page by page, which takes up to half of the time with scans: it keeps up to 1 GiB, in huge
/// pages where there are some.
constexpr std::array kWished = {
    "OMP_WAIT_POLICY=passive",
    "GLIBC_TUNABLES=glibc.malloc.hugetlb=1:glibc.malloc.mmap_threshold=1073741824:"
    "glibc.malloc.trim_threshold=1073741824"};

/// Whether both are values of the same variable.
bool is_same_variable(const char* a, const char* b) {
  const std::string_view name(a, std::size_t(std::strchr(a, '=') - a) + 1);
  return std::strncmp(b, name.data(), name.size()) == 0;
}

/// The program starts itself again with what it wishes and the user has not set; not for --version
/// and --help, which do not compute.
void start_again_as_wished(int argc, char** argv, char** environment) {
  constexpr std::size_t kMost = 4096;
  static std::array<const char*, kMost> wished;
  if (argc < 2 || argv[1][0] == '-') return;
  std::size_t count = 0;
  for (; environment[count] != nullptr; ++count) {
    if (count + kWished.size() + 1 >= kMost) return;  // then as it is
    wished[count] = environment[count];
  }
  const std::size_t given = count;
  for (const char* wish : kWished) {
    const auto is_set = [&](const char* some) { return is_same_variable(wish, some); };
    if (std::none_of(wished.begin(), wished.begin() + given, is_set)) wished[count++] = wish;
  }
  if (count == given) return;
  execve("/proc/self/exe", argv, const_cast<char**>(wished.data()));  // returns only if it fails
}

/// The first of all that runs, before any library's own beginning.
void start_early(int argc, char** argv, char** environment) {
  hold_interrupts_back();
  start_again_as_wished(argc, argv, environment);
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
