#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

/// What a child process hands to its parent: plain values, texts, and vectors of plain values.
namespace angio {

/// Thrown by the parent's end: the child has sent all that it will.
struct EndOfChild {
  bool timed_out = false;
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
  /// @param most_bytes  of a text or vector; what claims more is not believed
  ChildInput(int file, double silent_seconds, std::uint64_t most_bytes)
      : file_(file), silent_seconds_(silent_seconds), most_bytes_(most_bytes) {}
  /// @throws EndOfChild, Interrupted
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
    fill(values, count_of(sizeof(Value)));
  }

 private:
  /// Takes memory as the values come: a child that a hostile file has taken over could claim any
  /// count.
  template <class Values>
  void fill(Values& values, std::size_t count) {
    constexpr std::size_t kStepBytes = std::size_t(1) << 24;
    constexpr std::size_t kItem = sizeof(typename Values::value_type);
    values.clear();
    while (values.size() < count) {
      const std::size_t have = values.size();
      values.resize(have + std::min(count - have, kStepBytes / kItem + 1));
      read(values.data() + have, (values.size() - have) * kItem);
    }
  }
  [[nodiscard]] std::size_t count_of(std::size_t item_size);

  int file_;
  double silent_seconds_;
  std::uint64_t most_bytes_;
};

}  // namespace angio
