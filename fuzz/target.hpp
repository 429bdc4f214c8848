#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

/// A fuzz target is what the program does with bytes that nobody has checked. One of our errors is
/// an answer; anything else that is thrown, a crash, a hang or gigabytes are a fault.
///
/// With ANGIO_FUZZ each target is a libFuzzer program (LLVMFuzzerTestOneInput); without it all are
/// in `fuzz_replay`, which runs them over the corpora.
namespace angio::fuzz {

using Target = void (*)(std::string_view bytes);

/// Calls a target and ends the process where it throws what no user should see.
int run_target(Target target, std::string_view bytes);

/// The bytes as a file of that name, in a folder of this process. The next call replaces it.
std::filesystem::path file_of(std::string_view bytes, const char* name);

/// Names a target for fuzz_replay.
struct Registration {
  Registration(const char* name, Target target);
};

}  // namespace angio::fuzz

#if defined(ANGIO_FUZZ)
#define ANGIO_FUZZ_TARGET(name)                                                                 \
  static void name##_target(std::string_view bytes);                                            \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {           \
    return angio::fuzz::run_target(name##_target, {reinterpret_cast<const char*>(data), size}); \
  }                                                                                             \
  static void name##_target(std::string_view bytes)
#else
#define ANGIO_FUZZ_TARGET(name)                                                     \
  static void name##_target(std::string_view bytes);                                \
  static const angio::fuzz::Registration name##_registration(#name, name##_target); \
  static void name##_target(std::string_view bytes)
#endif
