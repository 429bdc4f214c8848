#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "testing/temporary_folder.hpp"

namespace angio::test {

struct ProgramResult {
  int exit_code = -1;
  std::string out;    ///< standard output
  std::string error;  ///< standard error
  [[nodiscard]] int error_line_count() const {
    int lines = 0;
    for (const char c : error) lines += c == '\n' ? 1 : 0;
    return lines;
  }
};

inline std::string file_text(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

inline nlohmann::json json_of(const std::filesystem::path& file) {
  return nlohmann::json::parse(file_text(file));
}

/// A temporary folder whose files are named in command lines.
class CommandFolder : public TemporaryFolder {
 public:
  [[nodiscard]] std::string operator/(const std::string& name) const {
    return (path() / name).string();
  }
};

/// Runs `angio ARGUMENTS` in a shell and waits for it.
inline ProgramResult run_program(const std::string& arguments) {
  const CommandFolder folder;
  const std::string command = std::string("'") + ANGIO_PROGRAM + "' " + arguments + " >'" +
                              folder / "out" + "' 2>'" + folder / "error" + "' </dev/null";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, file_text(folder.path() / "out"),
          file_text(folder.path() / "error")};
}

}  // namespace angio::test
