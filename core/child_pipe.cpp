#include "core/child_pipe.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "core/interrupt.hpp"
#include "core/system_call.hpp"

namespace angio {
namespace {

constexpr std::size_t kGatherBytes = std::size_t(1) << 16;
constexpr int kBrokenPipeStatus = 104;
constexpr double kLookAgainSeconds = 0.1;  ///< whether the user asks to stop

/// @return false: the child was silent for too long
bool wait_for_bytes(int file, double silent_seconds) {
  double left = silent_seconds;
  do {
    throw_if_interrupted();
    const double part = std::min(left, kLookAgainSeconds);
    if (is_ready(file, int(std::ceil(1000.0 * part)))) return true;
    left -= part;
  } while (left > 0.0);
  return false;
}

}  // namespace

void ChildOutput::write(const void* bytes, std::size_t size) {
  const auto* begin = static_cast<const char*>(bytes);
  if (gathered_.size() + size >= kGatherBytes) flush();
  if (size >= kGatherBytes)
    send(begin, size);
  else
    gathered_.insert(gathered_.end(), begin, begin + size);
}

void ChildOutput::put(const std::string& text) {
  put(std::uint64_t(text.size()));
  write(text.data(), text.size());
}

void ChildOutput::flush() {
  send(gathered_.data(), gathered_.size());
  gathered_.clear();
}

void ChildOutput::send(const char* bytes, std::size_t size) const {
  while (size > 0) {
    const ssize_t count = repeat([&] { return ::write(file_, bytes, size); });
    if (count <= 0) _exit(kBrokenPipeStatus);  // nobody listens any more
    bytes += count;
    size -= std::size_t(count);
  }
}

void ChildInput::read(void* bytes, std::size_t size) {
  auto* begin = static_cast<char*>(bytes);
  while (size > 0) {
    if (!wait_for_bytes(file_, silent_seconds_)) throw EndOfChild{true};
    const ssize_t got = repeat([&] { return ::read(file_, begin, size); });
    if (got <= 0) throw EndOfChild{false};
    begin += got;
    size -= std::size_t(got);
  }
}

std::size_t ChildInput::count_of(std::size_t item_size) {
  std::uint64_t count = 0;
  get(count);
  if (count > most_bytes_ / item_size) throw EndOfChild{false};
  return std::size_t(count);
}

void ChildInput::get(std::string& text) { fill(text, count_of(1)); }

}  // namespace angio
