#pragma once

/// SIGINT and SIGTERM. They end a program within about a second, at any moment: work that looks
/// for them ends in order, and what does not hear them in time ends with the process. Nothing is
/// lost by it, for files appear whole (core/atomic_file.hpp), and the next run removes what lies
/// half-written beside them.
namespace angio {

/// Makes SIGINT and SIGTERM a request to stop: see throw_if_interrupted(). A process that has not
/// ended 1 s after the first of them says so on standard error and ends with exit code 75.
/// A file grown beyond `ulimit -f` fails to be written, and ends no program.
void catch_interrupts();

/// For a program that waits for others to end, or shows a window: a request never ends it by
/// itself.
void end_in_own_time();

/// @throws Interrupted if the user has asked to stop
void throw_if_interrupted();

}  // namespace angio
