#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/child_pipe.hpp"
#include "core/sandbox.hpp"

/// Child processes: a function of ours that may crash or take too much, or another program. Neither
/// outlives this process, not even when it is killed, and both say in the same words how they
/// ended.
///
/// Linux ends a child with the thread that started it, so this thread has to outlive the child.
namespace angio {

enum class Confinement {
  sandbox,  ///< see enter_sandbox()
  none,     ///< work of our own, or with a network: files of any size, as this process
};

/// What a child process may take before it is ended.
struct ChildLimits {
  std::size_t memory_bytes = std::size_t(1) << 30;  ///< beyond what the program holds already
  int cpu_seconds = 600;
  double silent_seconds = 120.0;                        ///< without a byte sent to the parent
  ReachableFiles reach = {};                            ///< nothing else: see enter_sandbox()
  std::uint64_t written_bytes = 0;                      ///< into any one file
  std::uint64_t handed_bytes = std::uint64_t(1) << 28;  ///< a text or vector to the parent
  Confinement confinement = Confinement::sandbox;
};

enum class ChildEnd {
  done,
  refused,        ///< it threw one of our errors: see message
  out_of_memory,  ///< it met its memory limit
  timed_out,      ///< it met its limit of CPU time, or fell silent
  broke_down,     ///< a signal ended it, or it gave a status other than 0
};

struct ChildResult {
  ChildEnd end = ChildEnd::done;
  std::string message;  ///< of the error, if refused
  int signal = 0;       ///< that ended it; 0: none did
  int exit_status = 0;  ///< where no signal ended it
};

/// Runs `work` on data nobody has checked in a forked child under limits of memory and time, and
/// hands what it sends to `receive` here. However the child ends, this process goes on.
///
/// The child prints nothing, leaves no core file and is killed with this process. As a rule it is
/// shut into a sandbox (enter_sandbox()): what it needs beside limits.reach, `work` must hold
/// already, as a library's tables that are read at their first use.
///
/// @param work     in the child; may throw
/// @param receive  here; what it throws ends the child and is thrown on
/// @throws IoError if no process can be started, Interrupted if the user asks to stop meanwhile
ChildResult run_guarded(const ChildLimits& limits, const std::function<void(ChildOutput&)>& work,
                        const std::function<void(ChildInput&)>& receive);

enum class Session {
  shared,   ///< Ctrl-C in the terminal reaches the child, too
  its_own,  ///< it does not: this process ends the child
};

/// Another program, and how it is started.
struct ProgramCall {
  std::filesystem::path file;
  std::vector<std::string> arguments;  ///< without the program's own name
  std::filesystem::path log;  ///< is written anew with all that it prints; empty: nothing is
  Session session = Session::shared;
};

/// A program that runs beside this one. When this process dies, it gets SIGTERM, so that it can
/// remove what it has put into the temporary folder.
class ChildProgram {
 public:
  /// In the child, the end of a pipe that read_line reads from.
  static constexpr int kLineFile = 3;

  /// @throws IoError if the program cannot be started
  explicit ChildProgram(const ProgramCall& call);
  /// As end().
  ~ChildProgram();
  ChildProgram(ChildProgram&& other) noexcept;
  ChildProgram& operator=(ChildProgram&&) = delete;

  /// The next line that the child writes into kLineFile; empty if none comes in time.
  [[nodiscard]] std::string read_line(int timeout_ms) const;
  /// How it ended; nothing while it runs.
  [[nodiscard]] std::optional<ChildResult> result();
  /// Sends SIGTERM; what then becomes of the child, result() tells.
  void ask_to_end() const;
  /// Asks it to end, and kills it if it has not within `patience_ms`.
  ChildResult end(int patience_ms = 10'000);

 private:
  ChildResult wait();

  pid_t id_ = -1;       ///< -1: it has ended
  int line_file_ = -1;  ///< our end of the pipe
  ChildResult result_;
};

}  // namespace angio
