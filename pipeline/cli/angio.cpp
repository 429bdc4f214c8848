#include <fcntl.h>
#include <sysexits.h>
#include <unistd.h>

#include <cstdlib>

#include "pipeline/cli/commands.hpp"

namespace {

/// OpenMP's threads spin while they wait, which on a machine that runs anything else beside this
/// program costs more than the waiting. libgomp reads the policy when it is loaded, before main,
/// so the program starts itself again with it; not for --version and --help, which do not compute.
void wait_without_spinning(int argc, char** argv) {
  const bool computes = argc > 1 && argv[1][0] != '-';
  if (!computes || std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  setenv("OMP_WAIT_POLICY", "passive", 1);
  execv("/proc/self/exe", argv);  // returns only if it fails: then with spinning
}

/// What is opened first would otherwise take a closed stream's number, and be written into.
void open_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDWR) != stream) _exit(EX_IOERR);
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  wait_without_spinning(argc, argv);
  return angio::pipeline::run_command_line(argc, argv);
}
