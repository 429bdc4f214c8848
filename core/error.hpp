#pragma once

#include <stdexcept>
#include <string>

namespace angio {

/// What the program returns to the shell (docs/contract.md; after BSD sysexits).
enum class ExitCode : int {
  done = 0,
  some_cases_failed = 2,
  usage = 64,
  bad_data = 65,
  no_input = 66,
  unavailable = 69,
  internal = 70,
  cannot_create = 73,
  io = 74,
  interrupted = 75,
  bad_config = 78,
};

/// Anything that ends a run. The message is one line for the user: what happened, where, the
/// likely cause, and what to try. It never holds a patient's identity.
class Error : public std::runtime_error {
 public:
  Error(ExitCode exit_code, const std::string& message)
      : std::runtime_error(message), exit_code_(exit_code) {}
  [[nodiscard]] ExitCode exit_code() const noexcept { return exit_code_; }

 private:
  ExitCode exit_code_;
};

/// Bad input. Word it "<PROBLEM> (<WHY IT IS A PROBLEM>). <SUGGESTION>".
class InputError : public Error {
 public:
  explicit InputError(const std::string& message, ExitCode exit_code = ExitCode::bad_data)
      : Error(exit_code, message) {}
};

/// An option outside its range, named "section.key".
class OptionError : public Error {
 public:
  explicit OptionError(const std::string& message) : Error(ExitCode::bad_config, message) {}
};

/// Reading or writing failed (disk full, permission, a vanished file).
class IoError : public Error {
 public:
  explicit IoError(const std::string& message, ExitCode exit_code = ExitCode::io)
      : Error(exit_code, message) {}
};

/// The user asked to stop; running again goes on from the last whole stage.
class Interrupted : public Error {
 public:
  Interrupted()
      : Error(ExitCode::interrupted, "interrupted. Run the same command again to go on") {}
};

/// Our mistake, never the user's.
class InternalError : public Error {
 public:
  explicit InternalError(const std::string& message) : Error(ExitCode::internal, message) {}
};

namespace detail {
[[noreturn]] void fail_expectation(const char* condition, const char* file, int line);
}

}  // namespace angio

/// States what must hold if our own code is right; throws InternalError. Costs nothing in release.
#if defined(ANGIO_CHECKS)
#define ANGIO_EXPECT(condition) \
  ((condition) ? void(0) : ::angio::detail::fail_expectation(#condition, __FILE__, __LINE__))
#else
#define ANGIO_EXPECT(condition) void(0)
#endif
