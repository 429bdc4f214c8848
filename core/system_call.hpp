#pragma once

#include <poll.h>

#include <cerrno>

namespace angio {

/// A system call, made again where a signal has interrupted it.
template <class Call>
auto repeat(const Call& call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

/// Waits until a file can be read, or its other end is closed. @return false: not in time
inline bool is_ready(int file, int timeout_ms) {
  pollfd waiting{file, POLLIN, 0};
  return repeat([&] { return poll(&waiting, 1, timeout_ms); }) > 0;
}

}  // namespace angio
