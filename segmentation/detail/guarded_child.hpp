#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace angio::segmentation::detail {

/// What a child process may take before it is ended.
struct ChildLimits {
  std::size_t memory_bytes = std::size_t(1) << 30;  ///< beyond what the program holds already
  int cpu_seconds = 600;
  int silent_seconds = 120;  ///< without a byte sent to the parent
};

enum class ChildEnd {
  done,
  refused,        ///< it threw one of our errors: see message
  out_of_memory,  ///< it met its memory limit
  timed_out,      ///< it met its limit of CPU time, or fell silent
  broke_down,     ///< a signal ended it
};

struct ChildResult {
  ChildEnd end = ChildEnd::done;
  std::string message;  ///< of the error, if refused
};

/// The child's end of the pipe.
class ChildOutput {
 public:
  explicit ChildOutput(int file) : file_(file) {}
  void write(const void* bytes, std::size_t size);
  template <class Value>
  void put(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    write(&value, sizeof value);
  }
  void put(const std::string& text);
  template <class Value>
  void put(const std::vector<Value>& values) {
    static_assert(std::is_trivially_copyable_v<Value>);
    put(std::uint64_t(values.size()));
    write(values.data(), values.size() * sizeof(Value));
  }
  /// Sends what was gathered; without it the parent could not tell how far a dead child came.
  void flush();

 private:
  void send(const char* bytes, std::size_t size) const;

  int file_;
  std::vector<char> gathered_;
};

/// The parent's end of the pipe. Reading past the child's end leaves run_guarded's receive.
class ChildInput {
 public:
  ChildInput(int file, int silent_seconds) : file_(file), silent_seconds_(silent_seconds) {}
  void read(void* bytes, std::size_t size);
  template <class Value>
  void get(Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    read(&value, sizeof value);
  }
  void get(std::string& text);
  template <class Value>
  void get(std::vector<Value>& values) {
    static_assert(std::is_trivially_copyable_v<Value>);
    values.resize(count_of(sizeof(Value)));
    read(values.data(), values.size() * sizeof(Value));
  }

 private:
  [[nodiscard]] std::size_t count_of(std::size_t item_size);

  int file_;
  int silent_seconds_;
};

/// Runs `work` on data nobody has checked in a forked child under limits of memory and time, and
/// hands what it sends to `receive` here. However the child ends, this process goes on.
///
/// @param work     in the child; may throw
/// @param receive  here; what it throws ends the child and is thrown on
ChildResult run_guarded(const ChildLimits& limits, const std::function<void(ChildOutput&)>& work,
                        const std::function<void(ChildInput&)>& receive);

}  // namespace angio::segmentation::detail
